//! Python with the packages whose readers judge our files.

use crate::venv::{self, Venv};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The interpreter; `None`, and the reason on stderr, where there is no Python or no network.
pub(crate) fn python() -> Option<&'static Path> {
    venv::python().inspect_err(|why| ignored(why)).ok()
}

/// For packages that need it.
const NEWER: Venv = Venv {
    folder: "python-3.12",
    interpreter: "python3.12",
    requirements: include_str!("../requirements-3.12.txt"),
    no_deps: include_str!("../requirements-3.12-no-deps.txt"),
};

/// The interpreter of Python 3.12; `None`, and the reason on stderr, where there is none that starts
/// or no network.
pub(crate) fn python_3_12() -> Option<PathBuf> {
    let version = "import ensurepip, venv, sys; sys.exit(sys.version_info[:2] != (3, 12))";
    let started = Command::new(NEWER.interpreter).args(["-c", version]).output();
    if !started.is_ok_and(|output| output.status.success()) {
        ignored("there is no `python3.12` with `venv`, which LeRobot 0.6.1 needs");
        return None;
    }
    NEWER.python().inspect_err(|why| ignored(why)).ok()
}

/// What a script of ours under `python/` prints.
pub(crate) fn run(python: &Path, script: &str, arguments: &[&Path]) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/it/python").join(script);
    let output = Command::new(python).arg(script).args(arguments).output().unwrap();
    let [stdout, stderr] =
        [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(output.status.success(), "{stdout}{stderr}");
    stdout
}

/// Says that a test was not made, past the harness, which keeps what passing tests print.
pub(crate) fn ignored(why: &str) {
    let _ = writeln!(io::stderr(), "ignored: {why}");
}
