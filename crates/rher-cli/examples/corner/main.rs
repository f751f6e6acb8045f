//! `rher`, with a task of its own.

mod corner;

use rher_cli::Program;
use std::process::ExitCode;

fn main() -> ExitCode {
    Program::new().task::<corner::Corner, 1>().main()
}
