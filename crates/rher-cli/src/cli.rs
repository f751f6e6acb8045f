//! The command line: clap types, nothing else.

use crate::exit_code::Status;
use crate::film::{FilmFile, PictureSize, camera, film, size};
use crate::plot::{Clock, Measure};
use crate::printer::Verbosity;
use crate::values::{
    Assignment, Axis, ExperimentName, Seeds, columns, engine, episodes, method, or_help, picture,
    precision, preset, rate, recording, task, time, toml_integer, workers,
};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use rher_core::config::{EngineKind, Method, Precision, Preset};
use rher_envs::Task;
use rher_envs::render::Viewpoint;
use rher_record::export::DatasetId;
use rher_runs::Asked;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;
use std::time::Duration;

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
    /// Write a dataset of demonstrations in the format of Minari or LeRobot
    Export(ExportArgs),
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
    /// Print what completes commands, options and names of tasks in a shell
    Completions(CompletionsArgs),
    /// Write manual pages, one for each command
    Man(ManArgs),
}

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
pub(crate) struct TasksArgs {
    /// Print JSON: an array with one object per task, also with its dimensions, the length of its
    /// episodes, its tolerances and the names of all numbers
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher train push                          train until it succeeds 95 times in 100
  rher train push --method her --seed 2    the baseline: plain hindsight, no relay
  rher train pick --preset paper --envs 19 the published settings, 19 environments side by side
  rher train push --set 'agent.hidden=[128,128]' --set relay.mirror=0
  rher train tpush --from runs/dpush-rher-fast-1
  rher train --resume runs/push-rher-fast-1

Ctrl-C saves and exits 130; a second Ctrl-C exits at once. SIGTERM and SIGUSR1 do the same with 143, \
SIGHUP with 129, and they end the program within 4 seconds, at worst with the last checkpoint.")]
pub(crate) struct TrainArgs {
    /// Task to learn; `rher tasks` lists the tasks
    #[arg(required_unless_present = "resume", value_parser = task())]
    pub(crate) task: Option<Task>,

    #[command(flatten)]
    pub(crate) settings: SettingsArgs,

    /// Number of threads, which never changes the result [default: one for each core]
    #[arg(long, value_name = "N", value_parser = workers)]
    pub(crate) workers: Option<NonZeroUsize>,

    /// Run folder to create; by default `runs/<TASK>-<METHOD>-<PRESET>-<SEED>`
    ///
    /// The folder gets `config.toml`, `machine.toml`, `metrics.jsonl` (one line for each evaluation),
    /// `checkpoint/` and `policy.safetensors`. A folder that already holds a run is not touched.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Start with the networks of the run in this folder, which may be of another task
    ///
    /// Its last actor and critics, and its statistics of what is observed, become the first of the
    /// new run; all else starts anew. Inputs are found by their names, such as `block1.position.x`;
    /// those that only the new task has begin without influence. The task has the same hand and at
    /// least the same objects: push, then dpush, then tpush; pick, then stack, then tstack.
    /// `agent.hidden`, `agent.critics`, `agent.critic_layer_norm`, `relay.goal_frame` and
    /// `relay.object_order` are the same in both runs. The section `[from]` of `config.toml` names
    /// the run that was started from.
    #[arg(long, value_name = "RUN")]
    pub(crate) from: Option<PathBuf>,

    /// Record every N-th training episode for Foxglove, beginning with the first
    ///
    /// Episodes are recorded as training plays them, with the exploration of guide and learner. They
    /// are in `episodes-<FIRST>.mcap` in the run folder, or in `episodes-<FIRST>.part.mcap` while the
    /// program runs. `rher play` records a policy without exploration.
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

    /// Write event files for `tensorboard --logdir runs`, with the numbers of `metrics.jsonl`
    #[arg(long)]
    pub(crate) tensorboard: bool,

    /// Resume the run in this folder, as if it had never stopped
    ///
    /// A run that is at its end goes on to more steps with --env-steps, also if it was solved.
    ///
    /// The settings come from the checkpoint; only --workers, --quiet, --record-every,
    /// --tensorboard, --max-wall, --engine, --precision, --env-steps and --until may be given with it.
    #[arg(
        long,
        value_name = "DIR",
        conflicts_with_all = [
            "task", "preset", "method", "seed", "envs", "config", "set", "out", "from",
        ],
    )]
    pub(crate) resume: Option<PathBuf>,

    /// Save the run and end with exit status 16 after this time, as in `90s`, `55m` or `4h`
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(crate) max_wall: Option<Duration>,

    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Process that started this one, with which it ends: for the program's own processes
    #[arg(long, hide = true, value_name = "PID")]
    pub(crate) parent: Option<u32>,
}

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

/// Where settings come from.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Settings, in increasing order of precedence")]
pub(crate) struct SettingsArgs {
    /// Preset to start from; `fast` also applies the recipe of the task [default: fast]
    #[arg(long, value_parser = preset(), value_name = "PRESET")]
    pub(crate) preset: Option<Preset>,

    /// TOML file with settings to change; `rher config` prints all of them
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,

    /// A setting to change, as in `--set agent.discount=0.98`; may be repeated; `--set help` lists them
    #[arg(long, value_name = "KEY=VALUE", value_parser = or_help::<Assignment>())]
    pub(crate) set: Vec<Assignment>,

    /// Training method [default: rher]
    #[arg(long, value_parser = method(), value_name = "METHOD")]
    pub(crate) method: Option<Method>,

    /// Seed of all random numbers of the run
    #[arg(long, value_name = "N", value_parser = toml_integer(0))]
    pub(crate) seed: Option<u64>,

    /// End after this many environment steps of training; evaluations do not count
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) env_steps: Option<u64>,

    /// End after two consecutive evaluations with at least this success rate; 0 never ends the run
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(crate) until: Option<f32>,

    /// Compute engine of the networks
    #[arg(long, value_parser = engine(), value_name = "NAME")]
    pub(crate) engine: Option<EngineKind>,

    /// Precision of the networks' matrix products
    #[arg(long, value_parser = precision(), value_name = "NAME")]
    pub(crate) precision: Option<Precision>,

    /// Number of environments that step side by side between updates; it changes the result
    ///
    /// 1 is the paper's single process, 19 its multi-process setting.
    #[arg(long, value_name = "N", value_parser = toml_integer(1))]
    pub(crate) envs: Option<u64>,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher eval runs/push-rher-fast-1
  rher eval policy.safetensors --episodes 1000 --seed 7 --json
  rher eval runs/push-rher-fast-1 --set 'randomize.friction=[0.5,1.5]'

Episodes that fail are counted by kind, by the first of these that is true of one:
  dropped       an object has fallen, off the table, from the hand or from a tower: out of its place, it
                is lower than its goal and than before, and out of the hand
  disturbed     an object out of its place had been lying in it
  out of reach  an object out of its place lies, or should go, where the hand cannot get
  stuck         nothing moved in the last fifth of the episode
  late          something still moved when the time was over")]
pub(crate) struct EvalArgs {
    /// Run folder or policy file
    pub(crate) path: PathBuf,

    /// Number of episodes for each sub-task
    #[arg(long, value_name = "N", default_value = "100", value_parser = episodes)]
    pub(crate) episodes: NonZeroUsize,

    /// Seed of the evaluation episodes [default: one that training has not evaluated with]
    ///
    /// Training evaluates with the seed in `evaluation.env_seed`, which is 0, and decides by those
    /// episodes when it is solved; the default is one more than that.
    #[arg(long, value_name = "N", value_parser = toml_integer(0))]
    pub(crate) seed: Option<u64>,

    /// A setting of the environments to change, as in `--set randomize.action_delay=[0,2]`; may be
    /// repeated
    ///
    /// All others are as the policy was trained with. Only `randomize.…` and the settings of the task,
    /// `task.…`, can be changed; `rher config <TASK>` prints them.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<Assignment>,

    /// Number of threads, which never changes the result [default: one for each core]
    #[arg(long, value_name = "N", value_parser = workers)]
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
  rher play runs/push-rher-fast-1 --film push.gif
  rher play runs/push-rher-fast-1 --film push.mp4 --camera close --size 1280x720 --trim

A recording opens in Foxglove or Lichtblick without set-up. The 3D panel shows the scene, the goals, \
the hindsight goals (the end of the episode) and the goals of the current stage; `/frame` and `/action` \
are numbers to plot. `push.layout.json` beside it is a layout to import. Q is recorded if the path is a \
run folder with a checkpoint, since a policy file holds no critic.")]
pub(crate) struct PlayArgs {
    /// Run folder or policy file
    pub(crate) path: PathBuf,

    /// Number of episodes to play
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) episodes: NonZeroU64,

    /// Seed of the evaluation episodes, as in `rher eval`
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = toml_integer(0))]
    pub(crate) seed: u64,

    /// Record the episodes in this MCAP file
    #[arg(long, value_name = "FILE", value_parser = recording())]
    pub(crate) mcap: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) pictures: PictureArgs,
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("drawn").args(["film", "png_dir"]).multiple(true)))]
pub(crate) struct PictureArgs {
    /// Draw the episodes as one film: .gif, .mp4 or .webm
    ///
    /// The last two are made by `ffmpeg`, which has to be on PATH.
    #[arg(long, visible_alias = "gif", value_name = "FILE", value_parser = film())]
    pub(crate) film: Option<FilmFile>,

    /// Draw every step as a PNG file in this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) png_dir: Option<PathBuf>,

    /// From where to draw: `close` is `corner`, but as near as each episode allows
    #[arg(
        long,
        value_name = "NAME",
        default_value = Viewpoint::Corner.name(),
        value_parser = camera(),
        requires = "drawn"
    )]
    pub(crate) camera: Viewpoint,

    /// Width and height of pictures, in pixels
    #[arg(
        long,
        value_name = "WxH",
        default_value = "400x300",
        value_parser = size,
        requires = "drawn"
    )]
    pub(crate) size: PictureSize,

    /// Cut each episode of the film shortly after its success
    #[arg(long, requires = "film")]
    pub(crate) trim: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher replay push.mcap
  rher replay push.mcap --verify           exit 0 if every episode reproduces, 12 if one does not

`--verify` simulates every episode again from its seed and its actions, in the environment that the \
recording names, and compares every message bit for bit: poses, observations, rewards, distances, \
stages. It does not cover who acted, and Q, which depend on the learner.")]
pub(crate) struct ReplayArgs {
    /// Recording of `rher play --mcap` or `rher train --record-every`
    pub(crate) path: PathBuf,

    /// Simulate every episode again, and compare it
    #[arg(long)]
    pub(crate) verify: bool,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher export runs/push-rher-fast-1 --format minari --out data/rher/push-v0 --episodes 500
  rher export runs/push-rher-fast-1 --format lerobot --out push-lerobot
  rher export push.mcap --format minari --out push-minari

A run is played without exploration, as in `rher eval`; a recording is exported unchanged.
Minari: `minari.MinariDataset(\"DIR/data\")`; where DIR is `ROOT/rher/<TASK>-v0` and \
MINARI_DATASETS_PATH is ROOT, also `minari.load_dataset(\"rher/<TASK>-v0\")`. Observations are those \
of a GoalEnv. LeRobot: `LeRobotDataset(\"rher/<TASK>\", root=\"DIR\")`, version 3.0, 25 frames per \
second, without pictures; the goal is `observation.environment_state`.")]
pub(crate) struct ExportArgs {
    /// Run folder or policy file to play, or a recording
    pub(crate) path: PathBuf,

    /// Dataset format
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) format: FormatName,

    /// Folder of the dataset, which must not exist yet
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,

    /// Identity of a Minari dataset, as in `rher/push-v1` (by default, that of the task)
    #[arg(long, value_name = "ID")]
    pub(crate) dataset_id: Option<DatasetId>,

    /// Number of episodes to play, or of a recording's first episodes [default: 100, or all of them]
    #[arg(long, value_name = "N")]
    pub(crate) episodes: Option<NonZeroU64>,

    /// Seed of the episodes that are played, as in `rher eval`
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
  rher stats runs/push-* -o profiles.svg   performance profiles and comparisons as a picture too

Runs of the same task, method and preset are one group, each a sample of it. Intervals are 95 % \
bootstrap intervals over the runs of a group, from a fixed seed: the same runs give the same output.
The probability of improvement is the share of pairs of runs that the first group wins. Ties count \
half, and so do runs that ended before the other one reached the success rate.")]
pub(crate) struct StatsArgs {
    /// Run folders, each with `config.toml` and `metrics.jsonl`, or plans of `rher sweep`
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
    /// Run folders, each with `config.toml` and `metrics.jsonl`, or plans of `rher sweep`
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
    /// Run folders, each with `config.toml` and `metrics.jsonl`, or plans of `rher sweep`
    #[arg(required = true, value_name = "RUN")]
    pub(crate) runs: Vec<PathBuf>,

    /// Page to write
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher config push > run.toml              every setting, ready to be changed
  rher config push --explain               the same, with everything about each setting
  rher train push --config run.toml")]
pub(crate) struct ConfigArgs {
    /// Task to learn; `rher tasks` lists the tasks
    #[arg(value_parser = task())]
    pub(crate) task: Task,

    /// Explain every setting: what it does, its values and its range
    #[arg(long)]
    pub(crate) explain: bool,

    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
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

impl From<&SettingsArgs> for Asked {
    fn from(args: &SettingsArgs) -> Self {
        let SettingsArgs {
            preset,
            config,
            set,
            method,
            seed,
            env_steps,
            until,
            engine,
            precision,
            envs,
        } = args;
        let set = set.iter().map(|Assignment { key, value }| (key.clone(), value.clone()));
        Self {
            preset: *preset,
            config: config.clone(),
            set: set.collect(),
            method: *method,
            seed: *seed,
            env_steps: *env_steps,
            until: *until,
            engine: *engine,
            precision: *precision,
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
