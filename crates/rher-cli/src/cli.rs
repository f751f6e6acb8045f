//! The command line: clap types and value parsers, nothing else.

use crate::exit_code::Status;
use crate::printer::Verbosity;
use clap::builder::{
    PathBufValueParser, PossibleValuesParser, RangedU64ValueParser, TypedValueParser, ValueParser,
};
use clap::{Args, Parser, Subcommand, ValueEnum};
use rher_core::agent::config::EngineKind;
use rher_core::config::{Method, Preset};
use rher_envs::Task;
use rher_runs::Asked;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;
use std::str::FromStr;

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
    /// It gets `config.toml`, `metrics.jsonl` (one line for each evaluation), `checkpoint/` and
    /// `policy.safetensors`. A folder that already holds a run is left alone.
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

    /// Seeds of every combination, as in `1-5` or `1,2,7`
    #[arg(long, value_name = "SEEDS", default_value = "1-3")]
    pub(crate) seeds: Seeds,

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

    /// End every run after this many environment steps
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) env_steps: Option<u64>,

    /// End a run at the second evaluation running with at least this success rate; 0 never does
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(crate) until: Option<f32>,

    /// Runs at a time [default: one for each core]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<NonZeroUsize>,

    /// Folder of the runs' folders; by default `runs/sweep-<TASK>`
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Print JSON: an array with one object for each combination of settings
    #[arg(long)]
    pub(crate) json: bool,
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

    /// Seeds of every case, as in `1-5` or `1,2,7`
    #[arg(long, value_name = "SEEDS", default_value = "1-3")]
    pub(crate) seeds: Seeds,

    /// Settings to start from [default: paper]
    #[arg(long, value_enum, value_name = "PRESET")]
    pub(crate) preset: Option<PresetName>,

    /// End every run after this many environment steps, instead of the experiment's own number
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) env_steps: Option<u64>,

    /// Runs at a time [default: one for each core]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<NonZeroUsize>,

    /// Folder of the runs' folders; by default `runs/reproduce-<NAME>`
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Print JSON: an array with one object for each case
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

    /// For whom
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) format: DatasetFormat,

    /// Folder of the dataset, which must not be there yet
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,

    /// Episodes to play, or the first ones of a recording [default: 100, or all of a recording]
    #[arg(long, value_name = "N")]
    pub(crate) episodes: Option<NonZeroU64>,

    /// Which episodes are played: the same ones for the same number, as in `rher eval`
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = toml_integer(0))]
    pub(crate) seed: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DatasetFormat {
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

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum PresetName {
    /// Reaches the success rate soonest on your machine
    Fast,
    /// Reaches it in the fewest environment steps
    SampleEfficient,
    /// The published settings
    Paper,
}

impl PresetName {
    /// As on the command line.
    pub(crate) fn name(self) -> &'static str {
        Preset::from(self).name()
    }
}

impl From<PresetName> for Preset {
    fn from(name: PresetName) -> Self {
        match name {
            PresetName::Fast => Self::Fast,
            PresetName::SampleEfficient => Self::SampleEfficient,
            PresetName::Paper => Self::Paper,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ExperimentName {
    /// Table I: which policy acts before the object is reached, in training and in evaluation
    Policies,
    /// How near counts as reached: d of 0 to 12 cm
    ReachDistance,
    /// How often the guide acts: α of 0 to 0.8
    GuideRate,
    /// One environment against 19 side by side
    Envs,
    /// Plain hindsight, with as many updates as the relay makes, and with half
    Her,
    /// Whether reaching is lost while pushing is learned
    Forgetting,
    /// Table II: steps to 95 % on push and pick
    Table2,
}

impl ExperimentName {
    /// As on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Policies => "policies",
            Self::ReachDistance => "reach-distance",
            Self::GuideRate => "guide-rate",
            Self::Envs => "envs",
            Self::Her => "her",
            Self::Forgetting => "forgetting",
            Self::Table2 => "table2",
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum MethodName {
    /// Relay hindsight: every sub-task, guided exploration
    Rher,
    /// Plain hindsight: the last sub-task alone, no guide
    Her,
}

impl MethodName {
    /// As on the command line.
    pub(crate) fn name(self) -> &'static str {
        Method::from(self).name()
    }
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Rher => Self::Rher,
            MethodName::Her => Self::Her,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum EngineName {
    /// Burn's autodiff: the reference
    Burn,
    /// Explicit forward and backward passes over preallocated buffers
    Fused,
}

impl EngineName {
    /// As in settings.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Burn => "burn",
            Self::Fused => "fused",
        }
    }
}

impl From<EngineName> for EngineKind {
    fn from(name: EngineName) -> Self {
        match name {
            EngineName::Burn => Self::Burn,
            EngineName::Fused => Self::Fused,
        }
    }
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

/// One `KEY=VALUE` of `--set`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assignment {
    pub(crate) key: String,
    pub(crate) value: toml::Value,
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or("expected KEY=VALUE, as in `--set agent.discount=0.98`")?;
        Ok(Self { key: key.trim().to_owned(), value: toml_value(value.trim())? })
    }
}

/// One `KEY=VALUE,…` of `rher sweep --set`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    pub(crate) key: String,
    pub(crate) values: Vec<toml::Value>,
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, values) = text
            .split_once('=')
            .ok_or("expected KEY=VALUE,..., as in `--set relay.mirror=0,0.5`")?;
        let mut depth = 0_i32;
        let separated = values.split(|c| {
            depth += i32::from(c == '[') - i32::from(c == ']');
            c == ',' && depth == 0
        });
        let values = separated.map(|value| toml_value(value.trim())).collect::<Result<_, _>>()?;
        Ok(Self { key: key.trim().to_owned(), values })
    }
}

/// Seeds as in `1-3,7`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seeds(pub(crate) Vec<u64>);

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected seeds as in `1-5` or `1,2,7`".to_owned();
        let mut seeds = Vec::new();
        for part in text.split(',') {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let first: u64 = first.trim().parse().map_err(|_| wrong())?;
            let last: u64 = last.trim().parse().map_err(|_| wrong())?;
            if first > last || last - first >= 1000 {
                return Err(wrong());
            }
            seeds.extend((first..=last).filter(|seed| !seeds.contains(seed)).collect::<Vec<_>>());
        }
        Ok(Self(seeds))
    }
}

/// TOML, but a bare word needs no quotes.
fn toml_value(text: &str) -> Result<toml::Value, String> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    match toml::de::ValueDeserializer::parse(text).and_then(serde::Deserialize::deserialize) {
        Ok(value) => Ok(value),
        Err(_) if !text.is_empty() && text.chars().all(is_word) => Ok(text.into()),
        Err(error) => Err(format!("`{text}` is not a TOML value: {}", error.message())),
    }
}

fn task() -> ValueParser {
    let names = PossibleValuesParser::new(Task::ALL.iter().map(|task| task.name()));
    ValueParser::new(names.try_map(|name| name.parse::<Task>()))
}

/// Integers from `least` to the largest that TOML has.
fn toml_integer(least: u64) -> RangedU64ValueParser {
    clap::value_parser!(u64).range(least..=i64::MAX as u64)
}

/// Paths of recordings, by whose end Foxglove knows them.
fn recording() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        let fits = path.extension().is_some_and(|extension| extension == "mcap");
        fits.then_some(path).ok_or("expected a name that ends in `.mcap`")
    })
}

fn picture(name: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("svg" | "png") => Ok(path),
        _ => Err("expected a name that ends in .svg or .png".to_owned()),
    }
}

fn rate(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(rate) if (0.0..=1.0).contains(&rate) => Ok(rate),
        _ => Err("expected a number from 0 to 1".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn set_takes_toml_and_bare_words() {
        let value = |text: &str| text.parse::<Assignment>().unwrap().value;
        assert_eq!(value("a.b=[128, 64]"), toml::Value::from(vec![128, 64]));
        assert_eq!(value("a.b=1e-3"), toml::Value::from(0.001));
        assert_eq!(value("a.b = true"), toml::Value::from(true));
        assert_eq!(value("a.b=sample-efficient"), toml::Value::from("sample-efficient"));
        assert!("a.b=[1".parse::<Assignment>().is_err());
        assert!("a.b".parse::<Assignment>().is_err());
        assert!("a.b=".parse::<Assignment>().is_err());
    }

    #[test]
    fn a_sweep_takes_several_values_and_seeds() {
        let axis: Axis = "a.b=[1, 2],[3]".parse().unwrap();
        assert_eq!(axis.values, [toml::Value::from(vec![1, 2]), toml::Value::from(vec![3])]);
        let axis: Axis = "a.b=fan-in,xavier".parse().unwrap();
        assert_eq!(axis.values, [toml::Value::from("fan-in"), toml::Value::from("xavier")]);
        assert_eq!("1-3,7,2".parse(), Ok(Seeds(vec![1, 2, 3, 7])));
        for wrong in ["", "3-1", "a", "1,"] {
            assert!(wrong.parse::<Seeds>().is_err(), "{wrong}");
        }
    }
}
