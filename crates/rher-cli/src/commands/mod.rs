//! One module for each verb.

mod bench;
mod config;
mod eval;
mod export;
mod play;
mod plot;
mod replay;
mod report;
mod reproduce;
mod stats;
mod sweep;
mod tasks;
mod train;

pub(crate) use export::NoDatasetId;
pub(crate) use replay::NotReal;

use crate::cli::{BenchCommand, Command};
use crate::exit_code::Status;
use crate::printer::Printer;
use anyhow::Context as _;
use comfy_table::Table;
use comfy_table::presets::NOTHING;
use rher_envs::{Options, Task};
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Does what `command` says.
pub(crate) fn run(command: Command, printer: Printer) -> anyhow::Result<Status> {
    match command {
        Command::Tasks(args) => tasks::tasks(&args, printer)?,
        Command::Train(args) => return train::train(&args, printer),
        Command::Sweep(args) => return sweep::sweep(&args, printer),
        Command::Reproduce(args) => return reproduce::reproduce(&args, printer),
        Command::Eval(args) => eval::eval(&args, printer)?,
        Command::Export(args) => return export::export(&args, printer),
        Command::Play(args) => return play::play(&args, printer),
        Command::Replay(args) => replay::replay(&args, printer)?,
        Command::Stats(args) => stats::stats(&args, printer)?,
        Command::Plot(args) => plot::plot(&args, printer)?,
        Command::Report(args) => report::report(&args, printer)?,
        Command::Config(args) => config::config(&args, printer)?,
        Command::Bench(BenchCommand::Env(args)) => bench::env::bench_env(&args, printer)?,
        Command::Bench(BenchCommand::Update(args)) => bench::update::bench_update(&args, printer)?,
    }
    Ok(Status::Success)
}

/// The options that an environment of `task` was made with, from what runs and policies remember.
pub(crate) fn made_with(variant: &str, task: Task) -> anyhow::Result<Options> {
    if variant.is_empty() {
        return Ok(Options::of(task.options()));
    }
    variant.parse().with_context(|| format!("cannot read the options of `{task}`: {variant}"))
}

/// The warning that a recording was read up to its last whole episode.
fn unfinished(path: &Path) -> String {
    format!("`{}` is not finished: an episode at its end may be left out", path.display())
}

/// As many threads as were asked for, or as there are cores.
fn threads(asked: Option<NonZeroUsize>) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    asked.map_or_else(cores, NonZeroUsize::get)
}

/// A flag that the first Ctrl-C sets, telling what is done then; the second one ends the program.
fn stop_on_interrupt(
    tell: impl Fn(&str) + Send + 'static,
    line: &'static str,
) -> anyhow::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(Status::Interrupted as i32);
        }
        tell(line);
    })
    .context("cannot listen to Ctrl-C")?;
    Ok(stop)
}

/// An empty table without lines, as `awk` likes it.
pub(crate) fn table() -> Table {
    let mut table = Table::new();
    table.load_style(NOTHING);
    table
}

/// A table as text, without blanks around its lines.
pub(crate) fn text(table: &Table) -> String {
    table.lines().map(|line| line.trim().to_owned() + "\n").collect()
}
