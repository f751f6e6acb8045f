//! The program `rher`: train, evaluate and measure relay hindsight policies.
//!
//! It is a library so that the Python package can have the same command: [`main`] is all of it.

mod cells;
mod children;
mod chosen;
mod cli;
mod commands;
mod errors;
mod exit_code;
mod expected;
mod film;
mod flops;
mod host;
mod jobs;
mod numbers;
mod observe;
mod plot;
mod printer;
mod tables;
mod tips;
mod trained;
mod values;

pub use host::Program;

use clap::Parser as _;
use std::ffi::OsString;

/// Does what `arguments` say, of which the first is the name of the program, and returns the exit
/// status. `program` is what starts a process of the same program.
pub fn main(program: &Program, arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match cli::Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(mut error) => {
            tips::add(&mut error);
            // If the terminal does not take it, there is nowhere to say so.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(exit_code::Status::Usage as u8);
        }
    };
    let printer = printer::Printer::new(cli.verbosity());
    let status = commands::run(cli.command, program, printer).unwrap_or_else(|error| {
        let report = errors::report(&error);
        printer.error(&error, report.hint.as_deref());
        report.status
    });
    status as u8
}
