//! The program `rher`, as a file of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    rher_cli::Program::new().main()
}
