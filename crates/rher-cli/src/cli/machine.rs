//! Arguments about this machine, its shell and its speed.

use crate::values::{engine, precision, task};
use clap::{Args, Subcommand};
use rher_core::config::{EngineKind, Precision};
use rher_envs::Task;
use std::num::NonZeroUsize;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher completions bash > ~/.local/share/bash-completion/completions/rher
  rher completions zsh > ~/.zfunc/_rher             with `fpath+=~/.zfunc` before `compinit`
  rher completions fish > ~/.config/fish/completions/rher.fish")]
pub(crate) struct CompletionsArgs {
    /// Shell that reads them
    #[arg(value_enum, value_name = "SHELL")]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Example:
  rher man ~/.local/share/man/man1")]
pub(crate) struct ManArgs {
    /// Folder of the pages; it is made if it is not there
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Compute a little of push, dpush and drawer-box, and compare the hashes with those that every
    /// machine must find
    ///
    /// Takes seconds. The exit status is 1 if a hash differs.
    #[arg(long)]
    pub(crate) bits: bool,

    /// Print JSON: an object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// Environment steps per CPU-second with random actions, of one environment and of many
    Env(BenchEnvArgs),
    /// Milliseconds per update of the networks
    Update(BenchUpdateArgs),
}

#[derive(Debug, Args)]
pub(crate) struct BenchEnvArgs {
    /// Task to measure; may be repeated [default: every task]
    #[arg(long = "task", value_name = "TASK", value_parser = task())]
    pub(crate) tasks: Vec<Task>,

    /// Print the rate of one thread only: for the program's own processes
    #[arg(long, hide = true)]
    pub(crate) one_thread: bool,

    /// Print JSON: an array with one object per task
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchUpdateArgs {
    /// Rows in the batch; may be repeated [default: 128, 256, 1024, 2048]
    #[arg(long = "batch", value_name = "N")]
    pub(crate) batches: Vec<NonZeroUsize>,

    /// Dimension of the network input; may be repeated [default: 31, 81]
    #[arg(long, value_name = "N")]
    pub(crate) inputs: Vec<NonZeroUsize>,

    /// Threads of the learner; may be repeated [default: 1, 2]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Vec<NonZeroUsize>,

    /// Engine to measure [default: every engine]
    #[arg(long, value_parser = engine(), value_name = "NAME")]
    pub(crate) engine: Option<EngineKind>,

    /// Precision to measure; may be repeated [default: f32]
    #[arg(long = "precision", value_parser = precision(), value_name = "NAME")]
    pub(crate) precisions: Vec<Precision>,

    /// Print JSON: an array with one object per row
    #[arg(long)]
    pub(crate) json: bool,
}
