//! The command line: clap types, nothing else.

use crate::exit_code::Status;
use crate::printer::Verbosity;
use crate::values::{
    Assignment, Axis, EngineName, ExperimentName, MethodName, PresetName, Seeds, picture, rate,
    recording, task, toml_integer,
};
use clap::{Args, Parser, Subcommand, ValueEnum};
use rher_envs::Task;
use rher_record::export::DatasetId;
use rher_runs::Asked;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;

/// Relay Hindsight Experience Replay: robots that learn to push, pick and stack from sparse rewards.
#[derive(Debug, Parser)]
#[command(
    name = "rher",
    version,
    max_term_width = 100,
    propagate_version = true,
    after_help = "Start with `rher train push`.",
    after_long_help = format!("Start with `rher train push`.\n\n{}", Status::table()),
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

impl Cli {
    pub(crate) fn verbosity(&self) -> Verbosity {
        match &self.command {
            Command::Train(train) if train.quiet => Verbosity::Quiet,
            _ => Verbosity::Normal,
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the tasks: objects, sub-tasks, widths, episode length, tolerances
    Tasks(TasksArgs),
    /// Train a policy, from the beginning or on from a checkpoint
    Train(TrainArgs),
    /// Train with every combination of settings and seeds, a few runs at a time
    Sweep(SweepArgs),
    /// Repeat an experiment of the paper
    Reproduce(ReproduceArgs),
    /// Measure how often a policy succeeds, with a 95 % confidence interval
    Eval(EvalArgs),
    /// Play episodes of a policy, draw them, and record them for Foxglove
    Play(PlayArgs),
    /// List the episodes of a recording, or prove that they were real
    Replay(ReplayArgs),
    /// Write a dataset of demonstrations, for Minari or LeRobot
    Export(ExportArgs),
    /// Compare runs: how soon they succeed, how often in the end, and how sure that is
    Stats(StatsArgs),
    /// Draw learning curves, beside those that the authors published
    Plot(PlotArgs),
    /// Write one page about runs: curves, tables, an episode, settings
    Report(ReportArgs),
    /// Print every setting of a run as TOML, for `rher train --config`
    Config(ConfigArgs),
    /// Measure the speed of this machine
    #[command(subcommand)]
    Bench(BenchCommand),
}

#[derive(Debug, Args)]
pub(crate) struct TasksArgs {
    /// Print JSON: an array with one object for each task
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher train push                          train until it succeeds 95 times in 100
  rher train push --method her --seed 2    the baseline: plain hindsight, no relay
  rher train pick --preset paper --envs 19 the published settings, 19 environments side by side
  rher train push --set agent.hidden=[128,128] --set relay.mirror=0
  rher train --resume runs/push-rher-fast-1

Ctrl-C finishes the episode, saves and exits 130; a second Ctrl-C exits at once.")]
pub(crate) struct TrainArgs {
    /// What to learn; `rher tasks` says more
    #[arg(required_unless_present = "resume", value_parser = task())]
    pub(crate) task: Option<Task>,

    #[command(flatten)]
    pub(crate) settings: SettingsArgs,

    /// Threads that do the work; never part of the result [default: one for each core]
    #[arg(long, value_name = "N")]
    pub(crate) workers: Option<NonZeroUsize>,

    /// Run folder to make; by default `runs/<TASK>-<METHOD>-<PRESET>-<SEED>`
    ///
    /// It gets `config.toml`, `machine.toml`, `metrics.jsonl` (one line for each evaluation),
    /// `checkpoint/` and `policy.safetensors`. A folder that already holds a run is left alone.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Record every N-th training episode, the first one included, for Foxglove
    ///
    /// Episodes are as training plays them: explored with noise and chance, by guide and learner.
    /// They are in `episodes-<FIRST>.mcap` in the run folder, in `episodes-<FIRST>.part.mcap` while
    /// the run goes on. A policy without exploration is recorded by `rher play`.
    #[arg(long, value_name = "N")]
    pub(crate) record_every: Option<NonZeroU64>,

    /// Show episodes and metrics in Foxglove while training, on this WebSocket
    /// [default: 127.0.0.1:8765]
    #[cfg(feature = "live")]
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "127.0.0.1:8765"
    )]
    pub(crate) live: Option<std::net::SocketAddr>,

    /// Write event files for `tensorboard --logdir runs`: what `metrics.jsonl` holds
    #[arg(long)]
    pub(crate) tensorboard: bool,

    /// Go on with the run in this folder, as if it had never stopped
    ///
    /// Settings come from the checkpoint; only --workers, --quiet, --record-every,
    /// --tensorboard, --engine, --env-steps and --until may be given with it.
    #[arg(
        long,
        value_name = "DIR",
        conflicts_with_all = ["task", "preset", "method", "seed", "envs", "config", "set", "out"],
    )]
    pub(crate) resume: Option<PathBuf>,

    /// Tell errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher sweep push --seeds 1-5
  rher sweep push --seeds 1-3 --set relay.mirror=0,0.5 --set agent.discount=0.95,0.98
  rher sweep push --set agent.hidden=[256,256],[256,256,256] --jobs 1

Every run has a folder of its own, as `rher train` makes it, and one thread. The same command again
goes on with runs that were interrupted, and leaves finished ones alone.")]
pub(crate) struct SweepArgs {
    /// What to learn; `rher tasks` says more
    #[arg(value_parser = task())]
    pub(crate) task: Task,

    /// One setting and its values, as in `--set relay.mirror=0,0.5`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE,...")]
    pub(crate) vary: Vec<Axis>,

    /// Settings to start from
    #[arg(long, value_enum, value_name = "PRESET")]
    pub(crate) preset: Option<PresetName>,

    /// TOML file with the settings that should differ in every run
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,

    /// What is trained
    #[arg(long, value_enum, value_name = "METHOD")]
    pub(crate) method: Option<MethodName>,

    /// End a run at the second evaluation running with at least this success rate; 0 never does
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(crate) until: Option<f32>,

    /// Folder of the runs' folders; by default `runs/sweep-<TASK>`
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) runs: RunsArgs,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher reproduce policies                  Table I, seeds 1 to 3, the published settings
  rher reproduce guide-rate --seeds 1 --preset fast

Every run has a folder of its own, as `rher train` makes it, and one thread. The same command again
goes on with runs that were interrupted, and leaves finished ones alone. What the paper says of the
experiment is told first.")]
pub(crate) struct ReproduceArgs {
    /// Which experiment
    #[arg(value_enum, value_name = "NAME")]
    pub(crate) experiment: ExperimentName,

    /// Settings to start from [default: paper]
    #[arg(long, value_enum, value_name = "PRESET")]
    pub(crate) preset: Option<PresetName>,

    /// Folder of the runs' folders; by default `runs/reproduce-<NAME>`
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) runs: RunsArgs,
}

/// What commands that make many runs have in common.
#[derive(Debug, Args)]
pub(crate) struct RunsArgs {
    /// Seeds of every combination of settings, as in `1-5` or `1,2,7`
    #[arg(long, value_name = "SEEDS", default_value = "1-3")]
    pub(crate) seeds: Seeds,

    /// End every run after this many environment steps
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) env_steps: Option<u64>,

    /// Runs at a time [default: one for each core]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<NonZeroUsize>,

    /// Print JSON: an array with one object for each combination of settings
    #[arg(long)]
    pub(crate) json: bool,
}

/// Where settings come from.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Settings, each winning over those before it")]
pub(crate) struct SettingsArgs {
    /// Settings to start from; `fast` also takes the recipe of the task [default: fast]
    #[arg(long, value_enum, value_name = "PRESET")]
    pub(crate) preset: Option<PresetName>,

    /// TOML file with the settings that should differ; `rher config` prints all of them
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,

    /// One setting, as in `--set agent.discount=0.98`; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<Assignment>,

    /// What is trained [default: rher]
    #[arg(long, value_enum, value_name = "METHOD")]
    pub(crate) method: Option<MethodName>,

    /// Seed of every random draw
    #[arg(long, value_name = "N", value_parser = toml_integer(0))]
    pub(crate) seed: Option<u64>,

    /// End after this many environment steps; evaluations do not count
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) env_steps: Option<u64>,

    /// End at the second evaluation running with at least this success rate; 0 never does
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(crate) until: Option<f32>,

    /// Who does the arithmetic of the networks
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) engine: Option<EngineName>,

    /// Step this many environments side by side between updates: part of the experiment
    ///
    /// 1 is the paper's single process, 19 its multi-process setting.
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) envs: Option<u64>,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher eval runs/push-rher-fast-1
  rher eval policy.safetensors --episodes 1000 --seed 7 --json")]
pub(crate) struct EvalArgs {
    /// Run folder, or a policy file
    pub(crate) path: PathBuf,

    /// Episodes for each sub-task
    #[arg(long, value_name = "N", default_value = "100")]
    pub(crate) episodes: NonZeroUsize,

    /// Which episodes: the same ones for the same number; training evaluates on those of 0
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = toml_integer(0))]
    pub(crate) seed: u64,

    /// Threads that do the work; never part of the result [default: one for each core]
    #[arg(long, value_name = "N")]
    pub(crate) workers: Option<NonZeroUsize>,

    /// Print JSON: one object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher play runs/push-rher-fast-1 --episodes 10
  rher play runs/push-rher-fast-1 --mcap push.mcap
  rher play runs/push-rher-fast-1 --gif push.gif

A recording opens in Foxglove or Lichtblick with no set-up: the scene, the goals, what hindsight will
ask for (the end of the episode) and what the current stage asks for in the 3D panel, and `/frame` and
`/action` to plot. `push.layout.json` beside it is a layout to import. Q is told where the path is a run
folder with a checkpoint: a policy file holds no critic.")]
pub(crate) struct PlayArgs {
    /// Run folder, or a policy file
    pub(crate) path: PathBuf,

    /// Episodes to play
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) episodes: NonZeroU64,

    /// Which episodes: the same ones for the same number, as in `rher eval`
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = toml_integer(0))]
    pub(crate) seed: u64,

    /// Record the episodes in this MCAP file
    #[arg(long, value_name = "FILE", value_parser = recording())]
    pub(crate) mcap: Option<PathBuf>,

    /// Draw the episodes as one moving picture, in this GIF file
    #[arg(long, value_name = "FILE")]
    pub(crate) gif: Option<PathBuf>,

    /// Draw every step as a PNG file in this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) png_dir: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher replay push.mcap
  rher replay push.mcap --verify           exit 0 if every episode was real, 12 if one was not

A proof plays every episode again from its seed and its actions, in the environment that the recording
names, and compares every message bit for bit: poses, observations, rewards, distances, stages. It
does not cover who decided, and Q, which are the learner's.")]
pub(crate) struct ReplayArgs {
    /// Recording of `rher play --mcap` or `rher train --record-every`
    pub(crate) path: PathBuf,

    /// Play every episode again, and compare
    #[arg(long)]
    pub(crate) verify: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher export runs/push-rher-fast-1 --format minari --out data/rher/push-v0 --episodes 500
  rher export runs/push-rher-fast-1 --format lerobot --out push-lerobot
  rher export push.mcap --format minari --out push-minari

A run is played without exploration, as in `rher eval`; a recording is exported as it is.
Minari: `minari.MinariDataset(\"DIR/data\")`; where DIR is `ROOT/rher/<TASK>-v0` and
MINARI_DATASETS_PATH is ROOT, also `minari.load_dataset(\"rher/<TASK>-v0\")`. Observations are those
of a GoalEnv. LeRobot: `LeRobotDataset(\"rher/<TASK>\", root=\"DIR\")`, version 3.0, 25 frames per
second, without pictures; the goal is `observation.environment_state`.")]
pub(crate) struct ExportArgs {
    /// Run folder or policy file to play, or recording
    pub(crate) path: PathBuf,

    /// Dataset format
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) format: FormatName,

    /// Folder of the dataset, which must not be there yet
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,

    /// Identity of a Minari dataset, as in `rher/push-v1` [default: rher/<TASK>-v0]
    #[arg(long, value_name = "ID")]
    pub(crate) dataset_id: Option<DatasetId>,

    /// Episodes to play, or the first ones of a recording [default: 100, or all of a recording]
    #[arg(long, value_name = "N")]
    pub(crate) episodes: Option<NonZeroU64>,

    /// Which episodes are played: the same ones for the same number, as in `rher eval`
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = toml_integer(0))]
    pub(crate) seed: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatName {
    /// A Minari dataset, in its Parquet storage
    Minari,
    /// A LeRobot dataset, version 3.0
    Lerobot,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher stats runs/push-rher-fast-*         three seeds, one row
  rher stats runs/push-* --markdown        every method and preset, for a README
  rher stats runs/* --json

Runs of the same task, method and preset are one group, each a sample of it. Intervals are 95 %
bootstrap intervals over the runs of a group, from a fixed seed: the same runs give the same output.
The probability of improvement is the share of pairs of runs that the first group wins; ties, and
runs that ended before the other got there, count half.")]
pub(crate) struct StatsArgs {
    /// Run folders, each with `config.toml` and `metrics.jsonl`
    #[arg(required = true, value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,

    /// Print Markdown tables
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,

    /// Print JSON: one object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher plot runs/push-rher-fast-*          three seeds, one line with a band
  rher plot runs/* --x time -o curves.png  against the wall clock

A row of panels for each task: its success, and that of each sub-task before the last. Runs of the
same method and preset are one line, with a 95 % bootstrap band where there are several. A run that
has ended keeps its last success. An SVG file takes its letters from the fonts of whoever shows it;
a PNG file needs none.")]
pub(crate) struct PlotArgs {
    /// Run folders, each with `config.toml` and `metrics.jsonl`
    #[arg(required = true, value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,

    /// Picture to write; its name ends in .svg or .png
    #[arg(short, long, value_name = "FILE", default_value = "curves.svg", value_parser = picture)]
    pub(crate) out: PathBuf,

    /// The horizontal axis
    #[arg(long, value_enum, default_value_t = Clock::Steps)]
    pub(crate) x: Clock,

    /// What a line shows of several runs
    #[arg(long, value_enum, default_value_t = Measure::Mean)]
    pub(crate) measure: Measure,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher report runs/push-rher-fast-1
  rher report runs/* -o results.html

The page is one file that opens in any browser, without a network. It has curves, the tables of
`rher stats`, an episode of the first run of each group, and every setting.")]
pub(crate) struct ReportArgs {
    /// Run folders, each with `config.toml` and `metrics.jsonl`
    #[arg(required = true, value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,

    /// Page to write
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    pub(crate) out: PathBuf,
}

/// What curves are drawn against.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Clock {
    /// Environment steps of training
    Steps,
    /// Wall clock
    Time,
}

/// What is shown of several runs.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Measure {
    /// The mean
    Mean,
    /// The interquartile mean
    Iqm,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher config push > run.toml              every setting, ready to be changed
  rher train push --config run.toml")]
pub(crate) struct ConfigArgs {
    /// What to learn; `rher tasks` says more
    #[arg(value_parser = task())]
    pub(crate) task: Task,

    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// Steps per CPU-second of the environments, random actions; also of many stepped together
    Env(BenchEnvArgs),
    /// Milliseconds per update of the networks
    Update(BenchUpdateArgs),
}

#[derive(Debug, Args)]
pub(crate) struct BenchEnvArgs {
    /// Only this task; may be repeated [default: every task]
    #[arg(long = "task", value_name = "TASK", value_parser = task())]
    pub(crate) tasks: Vec<Task>,

    /// What the program asks of itself: the rate of one thread, and nothing else
    #[arg(long, hide = true)]
    pub(crate) one_thread: bool,

    /// Print JSON: an array with one object for each task
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchUpdateArgs {
    /// Rows in the batch; may be repeated [default: 128, 256, 1024, 2048]
    #[arg(long = "batch", value_name = "N")]
    pub(crate) batches: Vec<NonZeroUsize>,

    /// Numbers in a network input; may be repeated [default: 31, 81]
    #[arg(long, value_name = "N")]
    pub(crate) inputs: Vec<NonZeroUsize>,

    /// Threads of the learner; may be repeated [default: 1, 2]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Vec<NonZeroUsize>,

    /// Only this engine [default: every engine]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) engine: Option<EngineName>,

    /// Print JSON: an array with one object for each row
    #[arg(long)]
    pub(crate) json: bool,
}

impl From<&SettingsArgs> for Asked {
    fn from(args: &SettingsArgs) -> Self {
        let SettingsArgs { preset, config, set, method, seed, env_steps, until, engine, envs } =
            args;
        let set = set.iter().map(|Assignment { key, value }| (key.clone(), value.clone()));
        Self {
            preset: preset.map(Into::into),
            config: config.clone(),
            set: set.collect(),
            method: method.map(Into::into),
            seed: *seed,
            env_steps: *env_steps,
            until: *until,
            engine: engine.map(Into::into),
            envs: *envs,
        }
    }
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
