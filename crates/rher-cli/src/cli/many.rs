//! Arguments of commands that make many runs.

use crate::values::{
    Axis, ExperimentName, Seeds, method, or_help, preset, rate, task, time, toml_integer, workers,
};
use clap::{ArgGroup, Args};
use rher_core::config::{Method, Preset};
use rher_envs::Task;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher sweep push --seeds 1-5
  rher sweep push --seeds 1-3 --set relay.mirror=0,0.5 --set agent.discount=0.95,0.98
  rher sweep push --set 'agent.hidden=[256,256],[256,256,256]' --jobs 1
  rher sweep push pick --seeds 1-10 --set relay.mirror=0,0.5 --plan plan.jsonl
  rher sweep --plan plan.jsonl             train all of it here
  rher sweep --plan plan.jsonl --cell 3    train one of its cells, on any machine
  rher sweep --status plan.jsonl

Every run has its own folder, as `rher train` makes it, and one thread. The same command again \
resumes runs that were interrupted, and does not touch finished ones.

A plan is a file that machines with a common folder can share: each takes a cell at a time, and a \
cell that another one trains is left to it, with exit status 15. docs/sweeps.md explains both.")]
#[command(group(ArgGroup::new("one").args(["cell", "cell_from"])))]
pub(crate) struct SweepArgs {
    /// Tasks to learn; `rher tasks` lists the tasks
    #[arg(value_name = "TASK", required_unless_present_any = ["plan", "status"], value_parser = task())]
    pub(crate) tasks: Vec<Task>,

    /// A setting and its values, as in `--set relay.mirror=0,0.5`; may be repeated; `--set help` lists
    /// the settings
    #[arg(
        long = "set",
        value_name = "KEY=VALUE,...",
        requires = "tasks",
        value_parser = or_help::<Axis>(),
    )]
    pub(crate) vary: Vec<Axis>,

    /// Preset to start from
    #[arg(long, requires = "tasks", value_parser = preset(), value_name = "PRESET")]
    pub(crate) preset: Option<Preset>,

    /// TOML file with settings that all runs share
    #[arg(long, requires = "tasks", value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,

    /// Training method [default: rher]
    #[arg(long, requires = "tasks", value_parser = method(), value_name = "METHOD")]
    pub(crate) method: Option<Method>,

    /// Seeds for every combination of settings, as in `1-5` or `1,2,7`
    #[arg(long, requires = "tasks", value_name = "SEEDS", default_value = "1-3")]
    pub(crate) seeds: Seeds,

    /// End every run after this many environment steps
    #[arg(long, requires = "tasks", value_name = "N", value_parser = toml_integer(1))]
    pub(crate) env_steps: Option<u64>,

    /// End a run after two consecutive evaluations with at least this success rate; 0 never ends it
    #[arg(long, requires = "tasks", value_name = "RATE", value_parser = rate)]
    pub(crate) until: Option<f32>,

    /// Folder of the run folders; by default `runs/sweep-<TASK>`
    #[arg(long, requires = "tasks", value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Plan: with tasks it is written, and nothing is trained; without, its cells are trained
    #[arg(long, value_name = "FILE")]
    pub(crate) plan: Option<PathBuf>,

    /// Train this cell of the plan only, or continue it; the first cell is 0
    #[arg(long, value_name = "K", requires = "plan", conflicts_with_all = ["tasks", "jobs", "json"])]
    pub(crate) cell: Option<u64>,

    /// Train the cell whose number is in this environment variable, such as `SLURM_ARRAY_TASK_ID`
    #[arg(
        long,
        value_name = "VARIABLE",
        requires = "plan",
        conflicts_with_all = ["tasks", "jobs", "json"],
    )]
    pub(crate) cell_from: Option<String>,

    /// Number of threads of a cell, which never changes the result
    #[arg(long, value_name = "N", default_value = "1", requires = "one", value_parser = workers)]
    pub(crate) workers: NonZeroUsize,

    /// Save a cell and end with exit status 16 after this time, as in `90s`, `55m` or `4h`
    #[arg(long, value_name = "TIME", requires = "one", value_parser = time)]
    pub(crate) max_wall: Option<Duration>,

    /// Say how far the cells of this plan are, and train nothing
    #[arg(
        long,
        value_name = "PLAN",
        conflicts_with_all = ["tasks", "plan", "cell", "cell_from", "jobs"],
    )]
    pub(crate) status: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) runs: RunsArgs,

    /// Process that started this one, with which it ends: for the program's own processes
    #[arg(long, hide = true, value_name = "PID", requires = "cell")]
    pub(crate) parent: Option<u32>,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher reproduce policies                  Table I, seeds 1 to 3, the published settings
  rher reproduce guide-rate --seeds 1 --preset fast

Every run has its own folder, as `rher train` makes it, and one thread. The same command again \
resumes runs that were interrupted, and does not touch finished ones. What the paper reports \
of the experiment is printed first.")]
pub(crate) struct ReproduceArgs {
    /// Experiment to repeat
    #[arg(value_enum, value_name = "NAME")]
    pub(crate) experiment: ExperimentName,

    /// Preset to start from [default: paper; for `shipped` fast]
    #[arg(long, value_parser = preset(), value_name = "PRESET")]
    pub(crate) preset: Option<Preset>,

    /// Folder of the run folders; by default `runs/reproduce-<NAME>`
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Seeds for every combination of settings, as in `1-5` or `1,2,7` [default: 1-3; `shipped` has
    /// seed 1 alone]
    #[arg(long, value_name = "SEEDS")]
    pub(crate) seeds: Option<Seeds>,

    /// End every run after this many environment steps
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) env_steps: Option<u64>,

    #[command(flatten)]
    pub(crate) runs: RunsArgs,
}

/// What commands that make many runs have in common.
#[derive(Debug, Args)]
pub(crate) struct RunsArgs {
    /// Number of runs at a time [default: one for each core]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<NonZeroUsize>,

    /// Print JSON: an array with one object per combination of settings, or the status as one object
    #[arg(long)]
    pub(crate) json: bool,
}
