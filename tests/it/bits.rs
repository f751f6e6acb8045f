//! The same seed gives the same bits as ever, and by all instructions.

use crate::support::Rher;
use rher_bits::{known, tensors};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;

#[test]
fn short_runs_end_with_the_bits_that_they_had() {
    let rher = Rher::new();
    let mut wrong = String::new();
    for (task, policy, metrics) in known::PRESET_RUNS {
        rher.ok(&format!(
            "train {task} --seed 1 --env-steps 1200 --until 0 --quiet --out {task} \
             --set evaluation.every_episodes=5 --set evaluation.episodes=20 \
             --set evaluation.subtask_episodes=5"
        ));
        let file = std::fs::read(rher.path(task.name()).join("policy.safetensors")).unwrap();
        let lines = rher.metrics(task.name()).iter().map(Value::to_string).collect::<Vec<_>>();
        assert!(lines.len() > 1, "evaluations");
        let found = (tensors(&file).unwrap(), hash(lines.join("\n").as_bytes()));
        if found != (policy.to_owned(), metrics.to_owned()) {
            writeln!(wrong, "    (Task::{task:?}, {:?}, {:?}),", found.0, found.1).unwrap();
        }
    }
    assert!(wrong.is_empty(), "other than `PRESET_RUNS` says:\n{wrong}");
}

#[test]
fn every_set_of_instructions_has_the_same_bits() {
    let rher = Rher::new();
    let doctor = |simd: &str| {
        let ran = rher.command("doctor --bits --json").env("RHER_SIMD", simd).output().unwrap();
        let found: Value = serde_json::from_slice(&ran.stdout).unwrap_or_default();
        (ran.status.code(), found, String::from_utf8(ran.stderr).unwrap())
    };
    let (status, _, error) = doctor("none-of-these");
    assert_eq!(status, Some(2));
    assert!(error.contains("`none-of-these`") && error.contains("portable"), "{error}");

    let here: Value = serde_json::from_str(&rher.ok("doctor --json")).unwrap();
    assert!(here["bits"].is_null() && here["threads"].is_number(), "{here}");
    let available = here["available"].as_array().unwrap();
    assert!(available.contains(&here["instructions"]));
    for simd in available {
        let (status, found, error) = doctor(simd.as_str().unwrap());
        assert_eq!(found["instructions"], *simd);
        assert_eq!(status, Some(0), "{found:#}\n{error}");
        assert_eq!(found["bits"].as_array().unwrap().len(), 18);
    }
}

fn hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().take(8).fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}
