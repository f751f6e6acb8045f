//! The `rher` program: train, evaluate and measure relay hindsight policies.

mod children;
mod cli;
mod commands;
mod errors;
mod exit_code;
mod film;
mod flops;
mod host;
mod jobs;
mod numbers;
mod observe;
mod plot;
mod printer;
mod tables;
mod trained;
mod values;

use clap::Parser as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = cli::Cli::parse();
    let printer = printer::Printer::new(cli.verbosity());
    match commands::run(cli.command, printer) {
        Ok(status) => status.into(),
        Err(error) => {
            let report = errors::report(&error);
            printer.error(&error, report.hint.as_deref());
            report.status.into()
        }
    }
}
