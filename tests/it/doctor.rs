//! What `rher doctor` says of the machine.

use crate::python::ignored;
use crate::support::Rher;
use serde_json::{Value, json};
use std::process::{Command, Output};

fn found(output: &Output) -> Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn what_is_odd_is_said() {
    let rher = Rher::new();
    let mut doctor = rher.command("doctor --json");
    doctor.env_remove("RHER_SIMD").env("PATH", rher.path(""));
    let here = found(&doctor.output().unwrap());
    assert_eq!(here["odd"], json!([]), "{here}");
    assert_eq!(here["working_folder"]["problem"], Value::Null);
    assert_eq!(here["python"], Value::Null);

    doctor.env("TMPDIR", rher.path("nowhere"));
    let has_more = here["instructions"] != "portable";
    if has_more {
        doctor.env("RHER_SIMD", "portable");
    }
    let odd = found(&doctor.output().unwrap())["odd"].to_string();
    assert!(odd.contains("nowhere` cannot be written to"), "{odd}");
    assert_eq!(odd.contains("RHER_SIMD chooses portable"), has_more, "{odd}");
}

#[cfg(unix)]
#[test]
fn a_python_package_of_another_version_is_odd() {
    use std::os::unix::fs::PermissionsExt as _;

    let rher = Rher::new();
    let says = r#"{"interpreter": "/old/python3", "version": "3.10.1", "rher": "0.0.1"}"#;
    rher.write("python3", format!("#!/bin/sh\necho '{says}'\n"));
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(rher.path("python3"), executable).unwrap();
    let mut doctor = rher.command("doctor --json");
    doctor.env("PATH", rher.path(""));
    let odd = found(&doctor.output().unwrap())["odd"].to_string();
    assert!(odd.contains("`/old/python3` has version 0.0.1 of the package rher"), "{odd}");
}

/// The first x86-64 processors have SSE2 and nothing later; the program asks for no more.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
#[test]
fn every_x86_64_processor_is_enough() {
    let rher = Rher::new();
    let command = rher.command("doctor --json");
    let mut emulated = Command::new("qemu-x86_64");
    emulated.args(["-cpu", "Opteron_G1"]).arg(command.get_program()).args(command.get_args());
    let Ok(output) = emulated.output() else {
        ignored("there is no `qemu-x86_64`");
        return;
    };
    let here = found(&output);
    assert_eq!(here["available"], json!(["portable"]), "{here}");
}
