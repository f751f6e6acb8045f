//! Arguments of commands that act with a policy, or show what one did.

use crate::film::{FilmFile, PictureSize, camera, film, size};
use crate::values::{Assignment, episodes, recording, toml_integer, workers};
use clap::{ArgGroup, Args, ValueEnum};
use rher_envs::render::Viewpoint;
use rher_record::export::DatasetId;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher eval runs/push-rher-fast-1
  rher eval policy.safetensors --episodes 1000 --seed 7 --json
  rher eval runs/push-rher-fast-1 --set 'randomize.friction=[0.5,1.5]'

Episodes that fail are counted by kind, by the first of these that is true of one:
  dropped       an object fell: off the table, from the hand or from a tower
  disturbed     an object out of its place had been lying in it
  out of reach  an object lies, or should go, where the hand cannot get
  stuck         nothing moved in the last fifth of the episode
  late          something still moved when the time was over")]
pub(crate) struct EvalArgs {
    /// Run folder, policy file, or name of a task, whose policy ships with the program
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
    /// Run folder, policy file, or name of a task, whose policy ships with the program
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
  rher card runs/push-rher-fast-1 -o push-card
  rher card stack                          a policy that ships with the program

The folder is as the Hugging Face Hub has models: `README.md` with metadata, and beside it the policy, \
a moving picture, the settings and the metrics. Nothing is sent anywhere; `hf upload` does that. \
It is a run folder, too: `rher eval DIR`, `play` and `export` take it.")]
pub(crate) struct CardArgs {
    /// Run folder, or name of a task, whose run ships with the program
    #[arg(value_name = "RUN")]
    pub(crate) run: PathBuf,

    /// Folder of the card, which must not exist yet
    #[arg(short, long, value_name = "DIR", default_value = "card")]
    pub(crate) out: PathBuf,

    /// Number of episodes for each sub-task by which the policy is judged
    #[arg(long, value_name = "N", default_value = "500", value_parser = episodes)]
    pub(crate) episodes: NonZeroUsize,
}

#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  rher export runs/push-rher-fast-1 --format onnx --out push.onnx
  rher export runs/push-rher-fast-1 --format minari --out data/rher/push-v0 --episodes 500
  rher export runs/push-rher-fast-1 --format lerobot --out push-lerobot
  rher export push.mcap --format minari --out push-minari

ONNX: the policy with everything that it needs to act, for runtimes on robots and elsewhere; beside \
it, `push.json` says what its numbers are: names, units, frame, rate, limits.
A run is played without exploration, as in `rher eval`; a recording is exported unchanged.
Minari: `minari.MinariDataset(\"DIR/data\")`; where DIR is `ROOT/rher/<TASK>-v0` and \
MINARI_DATASETS_PATH is ROOT, also `minari.load_dataset(\"rher/<TASK>-v0\")`. Observations are those \
of a GoalEnv. LeRobot: `LeRobotDataset(\"rher/<TASK>\", root=\"DIR\")`, version 3.0, 25 frames per \
second, without pictures; the goal is `observation.environment_state`.")]
pub(crate) struct ExportArgs {
    /// Run folder or policy file, name of a task, whose policy ships with the program, or a recording
    /// for a dataset
    pub(crate) path: PathBuf,

    /// What to write
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) format: FormatName,

    /// Folder of the dataset, which must not exist yet, or file of the model [default for a model:
    /// policy.onnx]
    #[arg(
        long,
        value_name = "OUT",
        required = false,
        required_if_eq_any([("format", "minari"), ("format", "lerobot")]),
        default_value_if("format", "onnx", "policy.onnx"),
        hide_default_value = true
    )]
    pub(crate) out: PathBuf,

    /// Identity of a Minari dataset, as in `rher/push-v1` (by default, that of the task)
    #[arg(long, value_name = "ID")]
    pub(crate) dataset_id: Option<DatasetId>,

    /// Number of episodes to play, or of a recording's first episodes [default: 100, or all of them]
    #[arg(long, value_name = "N")]
    pub(crate) episodes: Option<NonZeroU64>,

    /// Seed of the episodes that are played, as in `rher eval` [default: 0]
    #[arg(long, value_name = "N", value_parser = toml_integer(0))]
    pub(crate) seed: Option<u64>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatName {
    /// The policy as an ONNX model, and a description of its numbers
    Onnx,
    /// A Minari dataset, in its Parquet storage
    Minari,
    /// A LeRobot dataset, version 3.0
    Lerobot,
}
