//! The Python package, tested by pytest.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../venv.rs"]
mod venv;

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::Command;

#[test]
#[cfg_attr(not(python3), ignore = "there is no `python3` from 3.10 on with `venv`")]
fn pytest_passes() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rher-py");
    let package = package.canonicalize().unwrap();
    let python = venv::python().unwrap();
    // What a user types, but with the build tools that are there already.
    let pip = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
    let mut install = Command::new(python);
    install.args(pip).arg("--no-build-isolation").arg(&package).env("PATH", path(python));
    // The comparison is tested, too.
    install.arg("--config-settings=build-args=--features measure");
    run(&mut install);
    let report = run(Command::new(python)
        .args(["-m", "pytest", "--quiet", "-rs", "-p", "no:cacheprovider", "--durations=5"])
        // On a shared machine PyTorch's threads wait for each other most of the time.
        .env("OMP_NUM_THREADS", "1")
        .env("RHER", env!("CARGO_BIN_EXE_rher"))
        .current_dir(&package));
    assert!(report.contains(" passed"), "pytest ran nothing:\n{report}");
    for skipped in report.lines().filter(|line| line.starts_with("SKIPPED")) {
        // Past the harness, which keeps what passing tests print.
        let _ = writeln!(io::stderr(), "{skipped}");
    }
}

/// Where programs are looked for: beside `python` first, where maturin is.
fn path(python: &Path) -> OsString {
    let beside = python.parent().unwrap().to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(beside).chain(std::env::split_paths(&path));
    std::env::join_paths(folders).unwrap()
}

/// Runs `command`, which must succeed, and returns what it printed.
fn run(command: &mut Command) -> String {
    // Cargo tells the test about itself, and what the test builds should not hear of it.
    let ours = std::env::vars_os().filter(|(name, _)| {
        let name = name.to_string_lossy();
        name.starts_with("CARGO_") && !matches!(&*name, "CARGO_HOME" | "CARGO_TARGET_DIR")
    });
    for (name, _) in ours {
        command.env_remove(name);
    }
    let output = command.output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    assert!(output.status.success(), "{command:?}: {}\n{said}", output.status);
    said
}
