//! One module for each verb.

mod bench;
mod card;
mod cell;
mod config;
mod doctor;
mod eval;
mod export;
mod pages;
mod play;
mod plot;
mod replay;
mod report;
mod reproduce;
mod runs;
mod ship;
mod stats;
mod status;
mod sweep;
mod tasks;
mod train;

use crate::cli::{BenchCommand, Command};
use crate::exit_code::Status;
use crate::host::Again;
use crate::printer::Printer;
use rher_core::learner::simd::Simd;

/// Does what `command` says.
pub(crate) fn run(command: Command, again: &Again, printer: Printer) -> anyhow::Result<Status> {
    Simd::chosen()?;
    match command {
        Command::Tasks(args) => tasks::tasks(&args, printer)?,
        Command::Train(args) => return train::train(&args, printer),
        Command::Sweep(args) => return sweep::sweep(&args, again, printer),
        Command::Reproduce(args) => return reproduce::reproduce(&args, again, printer),
        Command::Eval(args) => eval::eval(&args, printer)?,
        Command::Export(args) => return export::export(&args, printer),
        Command::Play(args) => return play::play(&args, printer),
        Command::Replay(args) => replay::replay(&args, printer)?,
        Command::Runs(args) => runs::runs(&args, printer)?,
        Command::Stats(args) => stats::stats(&args, printer)?,
        Command::Plot(args) => plot::plot(&args, printer)?,
        Command::Card(args) => card::card(&args, printer)?,
        Command::Report(args) => report::report(&args, printer)?,
        Command::Config(args) => config::config(&args, printer)?,
        Command::Doctor(args) => doctor::doctor(&args, again, printer)?,
        Command::Completions(args) => pages::completions(&args, printer)?,
        Command::Man(args) => pages::man(&args, printer)?,
        Command::Bench(BenchCommand::Env(args)) => bench::env::bench_env(&args, again, printer)?,
        Command::Bench(BenchCommand::Update(args)) => bench::update::bench_update(&args, printer)?,
    }
    Ok(Status::Success)
}
