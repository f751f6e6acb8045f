//! Tells the tests whether there is a Python that they can use.

use std::process::Command;

fn main() {
    println!("cargo::rustc-check-cfg=cfg(python3)");
    println!("cargo::rerun-if-env-changed=PATH");
    let new_enough = "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 10))";
    let python = Command::new("python3").args(["-c", new_enough]).output();
    if python.is_ok_and(|python| python.status.success()) {
        println!("cargo::rustc-cfg=python3");
    }
}
