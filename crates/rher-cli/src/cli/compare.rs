//! Arguments of commands that read runs and compare them.

use crate::plot::{Clock, Measure};
use crate::values::{columns, picture};
use clap::Args;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// Where runs are made unless something else is asked for.
pub(crate) const DEFAULT_FOLDER: &str = "runs";

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// Folder to look in, four levels deep
    #[arg(default_value = DEFAULT_FOLDER, value_name = "DIR")]
    pub(crate) folder: PathBuf,

    /// Print JSON: an array with one object per run
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher stats runs/push-rher-fast-*         three seeds, one row
  rher stats runs/push-* --markdown        every method and preset, for a README
  rher stats runs/* --json
  rher stats runs/push-* -o profiles.svg   performance profiles and comparisons as a picture too

Runs of the same task, method and preset are one group, each a sample of it. Intervals are 95 % \
bootstrap intervals over the runs of a group, from a fixed seed: the same runs give the same output.
The probability of improvement is the share of pairs of runs that the first group wins. Ties count \
half, and so do runs that ended before the other one reached the success rate.")]
pub(crate) struct StatsArgs {
    /// Run folders, each with `config.toml` and `metrics.jsonl`, plans of `rher sweep`, or names of
    /// tasks, whose run ships with the program
    #[arg(required = true, value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,

    /// Print Markdown tables
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,

    /// Print JSON: one object
    #[arg(long)]
    pub(crate) json: bool,

    /// Image file to write, too, with performance profiles and probabilities of improvement; its name
    /// ends in .svg or .png
    #[arg(short, long, value_name = "FILE", value_parser = picture())]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher plot runs/push-rher-fast-*          three seeds, one line with a band
  rher plot runs/* --x time -o curves.png  against the wall clock
  rher plot runs/* --no-subtasks --columns 2 --title 'All tasks'

For each task a panel of its success, and one of its sub-tasks before the last. Runs of the same \
method and preset are one line, with a 95 % bootstrap band where there are several; the picture says \
how many. A name has the same color in every picture. A run that has ended keeps its last success.
In an SVG file the pointer shows numbers; it is shown with the fonts of the viewer. A PNG file needs \
none.")]
pub(crate) struct PlotArgs {
    /// Run folders, each with `config.toml` and `metrics.jsonl`, plans of `rher sweep`, or names of
    /// tasks, whose run ships with the program
    #[arg(required = true, value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,

    /// Image file to write; its name ends in .svg or .png
    #[arg(short, long, value_name = "FILE", default_value = "curves.svg", value_parser = picture())]
    pub(crate) out: PathBuf,

    /// Horizontal axis
    #[arg(long, value_enum, default_value_t = Clock::Steps)]
    pub(crate) x: Clock,

    /// Statistic of several runs that a line shows
    #[arg(long, value_enum, default_value_t = Measure::Mean)]
    pub(crate) measure: Measure,

    /// Panels beside each other [default: at most 3]
    #[arg(long, value_name = "N", value_parser = columns)]
    pub(crate) columns: Option<NonZeroUsize>,

    /// Title above the panels
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,

    /// Leave out the panels of sub-tasks
    #[arg(long)]
    pub(crate) no_subtasks: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher report runs/push-rher-fast-1
  rher report runs/* -o results.html

The page is one file that opens in any browser, without a network and without scripts. It has curves, \
the tables and profiles of `rher stats`, an episode of the first run of each group, every metric, and \
what the settings change of their preset. Runs that are still running are marked.")]
pub(crate) struct ReportArgs {
    /// Run folders, each with `config.toml` and `metrics.jsonl`, plans of `rher sweep`, or names of
    /// tasks, whose run ships with the program
    #[arg(required = true, value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,

    /// Page to write
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    pub(crate) out: PathBuf,
}
