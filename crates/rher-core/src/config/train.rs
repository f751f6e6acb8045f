//! Settings of a whole run.

use super::declare::settings;
use super::preset::Start;
use super::started_from::StartedFrom;
use super::{AgentConfig, EvaluationConfig, ExplorationConfig, Preset, RelayConfig, ReplayConfig};
use crate::setting::Range;

/// Version of the settings' format; a file of another version is refused.
pub const VERSION: u32 = 1;

settings! {
    /// Settings of the whole run.
    pub struct TrainConfig in "", from start {
        /// Version of this format.
        pub version: u32 {
            paper: VERSION,
        }
        /// Name of the environment.
        pub task: String {
            paper: start.task.to_owned(),
        }
        /// Preset that the other settings start from.
        pub preset: Preset {
            paper: start.preset,
        }
        /// Seed of every random draw. The same seed and settings give the same policy.
        pub seed: u64 {
            range: Range::TOML,
            paper: 1,
        }
        /// Budget in environment steps, after which training ends. Steps of evaluations do not
        /// count.
        pub env_steps: u64 {
            range: Range::AtLeast(1),
            paper: match start.objects {
                1 => 1_000_000,
                2 => 1_200_000,
                _ => 4_200_000,
            },
            fast: match start.objects {
                1 => 300_000,
                2 => 1_200_000,
                _ => 2_400_000,
            },
        }
        /// Success rate at which training ends early. Training ends once two consecutive
        /// evaluations have at least this success rate in the last sub-task; with 0 it never ends
        /// early.
        pub until: f32 {
            range: Range::Share,
            paper: 0.95,
        }
        /// Number of environments that are stepped side by side between updates. The number of
        /// updates grows with it. 1 is the paper's single process, 19 its multi-process setting.
        pub envs: usize {
            range: Range::Between(1, 4096),
            paper: 1,
        }
        sections {
            pub relay: RelayConfig,
            pub exploration: ExplorationConfig,
            pub replay: ReplayConfig,
            pub agent: AgentConfig,
            pub evaluation: EvaluationConfig,
        }
        unwritten {
            /// Number of objects that the preset was asked for; `None` in settings read from a
            /// file, which take it from their task.
            #[serde(skip)]
            pub objects: Option<usize> = Some(start.objects),
            /// The run whose networks this one started with; `None` if it started with untrained
            /// ones. [`Trainer`](crate::Trainer) sets it.
            #[serde(
                default,
                with = "crate::since_6",
                skip_serializing_if = "Option::is_none"
            )]
            pub from: Option<StartedFrom> = None,
        }
    }
}

impl TrainConfig {
    /// Whether a run has solved its task: both of the last two evaluations reached `until`, and
    /// `until` is not 0.
    pub fn is_solved(&self, last_two: [f32; 2]) -> bool {
        self.until > 0.0 && last_two.into_iter().all(|rate| rate >= self.until)
    }
}

impl Preset {
    /// The settings of this preset for a task with `objects` objects.
    pub fn config(self, task: &str, objects: usize) -> TrainConfig {
        let single = objects == 1;
        TrainConfig::starting_from(&Start { task, preset: self, objects, single })
    }
}

impl AgentConfig {
    /// TD3 with the settings of the authors' multi-object code.
    pub fn td3() -> Self {
        Preset::Paper.config("", 2).agent
    }

    /// DDPG with the settings of the authors' single-object code.
    pub fn ddpg() -> Self {
        Preset::Paper.config("", 1).agent
    }
}
