//! Settings of a run: everything that is part of the experiment, and nothing that is not.

mod agent;
mod preset;
mod validate;

pub use agent::{AgentConfig, EngineKind, Init, TargetEvery};
pub use preset::Preset;
pub use validate::ConfigError;

use crate::env::EnvSpec;
use crate::goal::{LaterObjects, Tolerances};
use serde::{Deserialize, Serialize};

/// Version of the settings' format; a file of another version is refused.
pub const VERSION: u32 = 1;

/// Settings of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainConfig {
    /// Version of this format.
    pub version: u32,
    /// Name of the environment.
    pub task: String,
    /// The preset that the other settings started from.
    pub preset: Preset,
    /// Number of objects that the preset was asked for; `None` in settings read from a file, which
    /// take it from their task.
    #[serde(skip)]
    pub objects: Option<usize>,
    /// Seed of every random draw.
    pub seed: u64,
    /// Environment steps after which training ends; evaluation steps are not counted.
    pub env_steps: u64,
    /// Ends the run early, at the second evaluation running with at least this final success rate;
    /// 0 never does.
    pub until: f32,
    /// Environments stepped side by side between updates: 1 is the paper's single process, 19 its
    /// multi-process setting.
    pub envs: usize,
    /// The relay and its hindsight.
    pub relay: RelayConfig,
    /// Exploration.
    pub exploration: ExplorationConfig,
    /// Replay and updates.
    pub replay: ReplayConfig,
    /// The learner.
    pub agent: AgentConfig,
    /// Evaluation.
    pub evaluation: EvaluationConfig,
}

impl TrainConfig {
    /// Whether a run has solved its task: both of the last two evaluations reached `until`, and
    /// `until` is not 0.
    pub fn is_solved(&self, last_two: [f32; 2]) -> bool {
        self.until > 0.0 && last_two.into_iter().all(|rate| rate >= self.until)
    }
}

/// Which method is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Relay hindsight experience replay: every sub-task, guided exploration.
    Rher,
    /// Plain hindsight experience replay: the last sub-task alone, no guide.
    Her,
}

impl Method {
    /// Every method, the default first.
    pub const ALL: [Self; 2] = [Self::Rher, Self::Her];

    /// Name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rher => "rher",
            Self::Her => "her",
        }
    }
}

/// How goals enter the networks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GoalFrame {
    /// World positions, normalised; a blank slot is (−5, −5, −5). The paper.
    Absolute,
    /// What is left to go (goal − object, goal − gripper), normalised; a blank slot is 0, and one
    /// flag for each slot says which are blank.
    Relative,
}

/// In which order the networks see objects that are alike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectOrder {
    /// Always in relay order. The paper.
    #[default]
    Relay,
    /// From the object whose turn it is on, and round: the first that the sub-task wants somewhere
    /// else than where it is. What is to be done next looks the same for every object.
    Turn,
}

/// The relay and its hindsight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RelayConfig {
    /// Which method is trained.
    pub method: Method,
    /// The paper's d: how near the gripper must be to an object for it to count as reached when
    /// the stage is told (eq. 6), in metres.
    pub reach_distance: f32,
    /// Share of an environment's tolerance within which training has an object in its place, in
    /// rewards, stages and turns. Evaluations use the whole: below 1, training asks for more.
    #[serde(default = "whole")]
    pub tolerance: f32,
    /// Share of transitions that are replayed with a goal reached later in their episode.
    pub hindsight: f32,
    /// What hindsight asks of objects that a sub-task leaves alone.
    pub later_objects: LaterObjects,
    /// How goals enter the networks.
    pub goal_frame: GoalFrame,
    /// In which order the networks see objects that are alike.
    #[serde(default)]
    pub object_order: ObjectOrder,
    /// Share of transitions that are replayed as their mirror image, where the scene has one.
    pub mirror: f32,
    /// Share of a later object's transitions that are replayed as if it were an earlier one that
    /// is like it: what is learned of the first object is learned of all.
    #[serde(default)]
    pub exchange: f32,
}

/// What runs had before there was a choice.
fn whole() -> f32 {
    1.0
}

impl RelayConfig {
    /// How near counts as there, in training in environments like `spec`.
    pub fn tolerances<const N: usize>(&self, spec: &EnvSpec<N>) -> Tolerances<N> {
        let Tolerances { gripper, objects } = spec.tolerances;
        Tolerances { gripper, objects: objects.map(|tolerance| self.tolerance * tolerance) }
    }
}

/// Which policy acts before the object is reached: the cases of the paper's Table I.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrainPolicy {
    /// The guide and the learner in turn, as eq. 10 draws them.
    Mix,
    /// The guide alone.
    Guide,
}

/// Which policy is evaluated: the cases of the paper's Table I.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TestPolicy {
    /// The policy of the sub-task under test, from start to end.
    Final,
    /// The policy of the stage that the scene is in.
    Guide,
    /// At every step one of the two, with equal chances.
    Mix,
}

/// Exploration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExplorationConfig {
    /// The paper's α: probability that the guide acts. α + β may be 1.
    pub guide: f32,
    /// The paper's β: probability of a uniformly random action.
    pub random: f32,
    /// Steps for which a random action is kept, on average; 1 in the paper. β stays the share of
    /// all steps.
    #[serde(default = "one_step")]
    pub random_steps: f32,
    /// Standard deviation of the Gaussian noise on every other action.
    pub noise: f32,
    /// Scale `random` and `noise` by 1 − success rate of the sub-task whose policy acts (AAES).
    pub adjust_to_success: bool,
    /// The paper's sr: a sub-task whose success rate is above this guides; 1 keeps the first one.
    pub success_threshold: f32,
    /// Success rates are means over this many evaluations.
    pub window: usize,
    /// Who acts before the object is reached, in training.
    pub train_policy: TrainPolicy,
    /// Who acts in evaluation.
    pub test_policy: TestPolicy,
}

fn one_step() -> f32 {
    1.0
}

/// How the sub-tasks share an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BatchMode {
    /// One update after the other, each with the rows of one sub-task: Algorithm 1, and the
    /// authors' single-object code.
    Separate,
    /// One update with the rows of all: the authors' multi-object code.
    Joint,
}

/// Replay and updates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReplayConfig {
    /// Transitions kept; the oldest episodes go first.
    pub capacity: usize,
    /// Rows of each sub-task in an update; in a joint one, on average.
    pub batch_size: usize,
    /// Share of a joint update's rows that sub-tasks get by how often they still fail; the others
    /// are dealt out evenly.
    #[serde(default)]
    pub focus: f32,
    /// How the sub-tasks share an update.
    pub batch_mode: BatchMode,
    /// Rounds of updates after every episode; a round updates every sub-task once.
    pub updates_per_episode: usize,
    /// Episodes before the first update.
    pub warmup_episodes: u64,
}

/// Evaluation: deterministic policy, fixed episodes, success at the last step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EvaluationConfig {
    /// Training episodes between two evaluations.
    pub every_episodes: u64,
    /// Episodes for the last sub-task.
    pub episodes: usize,
    /// Episodes for each sub-task before it.
    pub subtask_episodes: usize,
    /// Which episodes: the same ones for every run with this number.
    pub env_seed: u64,
}
