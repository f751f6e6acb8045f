//! Arguments that train: what a run is, and where its settings come from.

use crate::values::{
    Assignment, engine, method, or_help, precision, preset, rate, task, time, toml_integer, workers,
};
use clap::Args;
use rher_core::config::{EngineKind, Method, Precision, Preset};
use rher_envs::Task;
use rher_runs::Asked;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;
use std::time::Duration;

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
