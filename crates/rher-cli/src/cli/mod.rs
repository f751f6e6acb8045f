//! The command line: clap types, nothing else.

mod compare;
mod machine;
mod many;
mod policy;
#[cfg(test)]
mod reference;
mod train;

pub(crate) use compare::{DEFAULT_FOLDER, ListArgs, PlotArgs, ReportArgs, StatsArgs};
pub(crate) use machine::{
    BenchCommand, BenchEnvArgs, BenchUpdateArgs, CompletionsArgs, DoctorArgs, ManArgs,
};
pub(crate) use many::{ReproduceArgs, SweepArgs};
pub(crate) use policy::{
    CardArgs, EvalArgs, ExportArgs, FormatName, PictureArgs, PlayArgs, ReplayArgs,
};
pub(crate) use train::{ConfigArgs, SettingsArgs, TrainArgs};

use crate::exit_code::Status;
use crate::printer::Verbosity;
use clap::{Args, Parser, Subcommand};

/// Relay Hindsight Experience Replay: robots that learn to push, pick and stack from sparse rewards.
#[derive(Debug, Parser)]
#[command(
    name = "rher",
    version,
    max_term_width = 100,
    propagate_version = true,
    after_help = "Start with `rher play stack --film stack.gif`, and with `rher train push`.",
    after_long_help = format!("Start with `rher play stack --film stack.gif`, and with `rher train push`.\n\n{}", Status::table()),
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

impl Cli {
    pub(crate) fn verbosity(&self) -> Verbosity {
        match &self.command {
            Command::Train(train) if train.quiet => Verbosity::Quiet,
            Command::Sweep(sweep) if sweep.parent.is_some() => Verbosity::Quiet,
            _ => Verbosity::Normal,
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the tasks: what there is to do, and how long it usually takes to learn
    Tasks(TasksArgs),
    /// Train a policy, or resume a run from its checkpoint
    Train(TrainArgs),
    /// Train with every combination of settings and seeds, several runs at a time
    Sweep(SweepArgs),
    /// Repeat an experiment of the paper
    Reproduce(ReproduceArgs),
    /// Measure the success rate of a policy, with a 95 % confidence interval
    Eval(EvalArgs),
    /// Play episodes of a policy, and draw or record them
    Play(PlayArgs),
    /// List the episodes of a recording, or verify that they reproduce bit for bit
    Replay(ReplayArgs),
    /// Write a policy as an ONNX model, or its episodes as a dataset for Minari or LeRobot
    Export(ExportArgs),
    /// Write a model card: a policy with its numbers, a moving picture and its settings
    Card(CardArgs),
    /// List the runs below a folder: how far they are, and whether they go on
    Runs(ListArgs),
    /// Compare runs: sample efficiency, final success, confidence intervals
    Stats(StatsArgs),
    /// Draw learning curves, with those that the authors published
    Plot(PlotArgs),
    /// Write one HTML page about runs: curves, tables, an episode, settings
    Report(ReportArgs),
    /// Print every setting of a run as TOML, for `rher train --config`
    Config(ConfigArgs),
    /// Say what this machine is, and whether it computes the same bits as every other
    Doctor(DoctorArgs),
    /// Measure the speed of this machine
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Print what completes commands and options in a shell
    ///
    /// In bash and zsh it completes names of tasks, too.
    Completions(CompletionsArgs),
    /// Write manual pages, one for each command
    Man(ManArgs),
}

#[derive(Debug, Args)]
pub(crate) struct TasksArgs {
    /// Print JSON: an array with one object per task, also with its dimensions, the length of its
    /// episodes, its tolerances and the names of all numbers
    #[arg(long)]
    pub(crate) json: bool,
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
