//! The program `rher`, run by Python.

use pyo3::prelude::*;
use rher_cli::Program;
use std::ffi::OsString;
use std::path::PathBuf;

/// Does what `arguments` say, of which the first is the name of the program, and returns the exit
/// status.
///
/// `interpreter` with `program` before its arguments starts another process of it.
#[pyfunction]
pub(crate) fn main(
    py: Python<'_>,
    arguments: Vec<OsString>,
    interpreter: PathBuf,
    program: Vec<OsString>,
) -> u8 {
    let program = Program::interpreted(interpreter, program);
    py.detach(|| program.run(arguments))
}
