//! The program `rher`, as a file of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    rher_cli::main(&rher_cli::Program::this_file(), std::env::args_os()).into()
}
