//! Training on a WebSocket, as Foxglove sees it.

use crate::python::{self, python};
use crate::support::{Rher, TINY};
use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::Stdio;

#[test]
fn training_can_be_watched() {
    let Some(python) = python() else { return };
    let rher = Rher::new();
    let arguments = format!("train push --out run --live=127.0.0.1:0 {TINY}");
    let mut training = rher.command(&arguments).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(training.stderr.take().unwrap()).lines();
    let line = lines.find_map(|line| Some(line.unwrap().split_once("ws://")?.1.to_owned()));
    // Nobody reads on, and nobody should have to.
    let reader = std::thread::spawn(move || lines.count());
    let address = format!("ws://{}", line.unwrap());
    assert!(address.starts_with("ws://127.0.0.1:"), "{address}");
    let seen = python::run(python, "live.py", &[Path::new(&address)]);
    training.kill().unwrap();
    training.wait().unwrap();
    reader.join().unwrap();

    let seen: Value = serde_json::from_str(&seen).unwrap();
    assert_eq!(seen["name"], "rher train");
    assert_eq!(
        seen["schemas"],
        json!({
            "/tf": "foxglove.FrameTransforms",
            "/scene": "foxglove.SceneUpdate",
            "/episode": "rher.Episode",
            "/frame": "rher.Frame",
            "/action": "rher.Action",
            "/metrics": "rher.Metrics",
        })
    );
    for topic in ["/tf", "/scene", "/episode", "/frame", "/action", "/metrics"] {
        assert!(seen["counts"][topic].as_u64() > Some(0), "{topic}: {seen}");
    }
}

#[test]
fn a_port_that_is_taken_is_told() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let ran = Rher::new().run(&format!("train push --env-steps 1 --live={address} {TINY}"));
    assert_eq!(ran.status, Some(13), "{ran}");
    assert!(ran.stderr.contains(&format!("cannot serve on {address}")), "{ran}");
    assert!(ran.stderr.contains("--live=127.0.0.1:0"), "{ran}");
}
