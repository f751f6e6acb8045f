//! The `rher` program: train, evaluate and measure relay hindsight policies.

mod animation;
mod chart;
mod cli;
mod commands;
mod curves;
mod error;
mod exit_code;
mod figure;
mod film;
mod jobs;
mod observe;
mod pictures;
mod printer;
mod published;
mod runs;
mod statistics;
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
            let report = error::Report::of(&error);
            printer.error(&error, report.hint.as_deref());
            report.status.into()
        }
    }
}
