//! Python with the packages whose readers judge our files.

use crate::venv;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The interpreter; `None`, and the reason on stderr, where there is no Python or no network.
pub(crate) fn python() -> Option<&'static Path> {
    venv::python().inspect_err(|why| ignored(why)).ok()
}

/// The interpreter of Python 3.12; `None`, and the reason on stderr, where there is none that starts
/// or no network.
pub(crate) fn python_3_12() -> Option<PathBuf> {
    venv::python_3_12().inspect_err(|why| ignored(why)).ok()
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
