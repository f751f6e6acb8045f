//! Named starting points for a run's settings.

use super::{
    AgentConfig, BatchMode, EvaluationConfig, ExplorationConfig, GoalFrame, Method, ObjectOrder,
    RelayConfig, ReplayConfig, TestPolicy, TrainConfig, TrainPolicy, VERSION,
};
use crate::goal::LaterObjects;
use serde::{Deserialize, Serialize};

/// A named starting point for a run's settings.
///
/// ```
/// use rher_core::Preset;
///
/// let mut config = Preset::Fast.config("carry", 1);
/// config.seed = 3;
/// config.agent.hidden = vec![64, 64];
/// assert!(config.validate().is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Reaches the success rate soonest on the user's machine.
    Fast,
    /// Reaches it in the fewest environment steps.
    SampleEfficient,
    /// The published settings.
    Paper,
}

impl Preset {
    /// Every preset, the default first.
    pub const ALL: [Self; 3] = [Self::Fast, Self::SampleEfficient, Self::Paper];

    /// Name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::SampleEfficient => "sample-efficient",
            Self::Paper => "paper",
        }
    }

    /// The settings of this preset for a task with `objects` objects.
    pub fn config(self, task: &str, objects: usize) -> TrainConfig {
        let paper = paper(task, objects);
        match self {
            Self::Paper => paper,
            Self::Fast => fast(paper, objects),
            Self::SampleEfficient => sample_efficient(paper, objects),
        }
    }
}

/// The authors' settings: their single-object code for one object, their multi-object code for
/// more, but with the mean squared action as penalty and every sub-task trained.
fn paper(task: &str, objects: usize) -> TrainConfig {
    let single = objects == 1;
    TrainConfig {
        version: VERSION,
        task: task.to_owned(),
        preset: Preset::Paper,
        objects: Some(objects),
        seed: 1,
        env_steps: match objects {
            1 => 1_000_000,
            2 => 1_200_000,
            _ => 4_200_000,
        },
        until: 0.95,
        envs: 1,
        relay: RelayConfig {
            method: Method::Rher,
            reach_distance: if single { 0.03 } else { 0.05 },
            tolerance: 1.0,
            hindsight: 0.8,
            later_objects: LaterObjects::Now,
            goal_frame: GoalFrame::Absolute,
            object_order: ObjectOrder::Relay,
            mirror: 0.0,
            exchange: 0.0,
        },
        exploration: ExplorationConfig {
            guide: 0.4,
            random: 0.2,
            random_steps: 1.0,
            noise: 0.2,
            adjust_to_success: !single,
            success_threshold: if single { 1.0 } else { 0.8 },
            window: 10,
            train_policy: TrainPolicy::Mix,
            test_policy: TestPolicy::Final,
        },
        replay: ReplayConfig {
            capacity: 1_000_000,
            batch_size: if single { 256 } else { 2048 },
            focus: 0.0,
            batch_mode: if single { BatchMode::Separate } else { BatchMode::Joint },
            updates_per_episode: 40,
            warmup_episodes: if single { 0 } else { 50 },
        },
        agent: if single { AgentConfig::ddpg() } else { AgentConfig::td3() },
        evaluation: EvaluationConfig {
            every_episodes: 50,
            episodes: 100,
            subtask_episodes: 20,
            env_seed: 0,
        },
    }
}

/// Relative goals, mirrored batches, TD3's two critics, networks of two hidden layers, targets that
/// move with every update, γ 0.95, d = 3 cm, and all sub-tasks in one joint batch of half the rows.
///
/// One object: as many updates as its two sub-tasks make in the paper. More: fewer updates for
/// more data, a smaller action penalty and layer normalization, which the longer sub-tasks need,
/// alike objects in order of turn, imitation of the simpler sub-tasks, more rows for those that
/// still fail, random actions that are kept for a few steps, and a guide that moves on sooner.
fn fast(paper: TrainConfig, objects: usize) -> TrainConfig {
    let single = objects == 1;
    TrainConfig {
        preset: Preset::Fast,
        env_steps: match objects {
            1 => 300_000,
            2 => 1_200_000,
            _ => 2_400_000,
        },
        relay: RelayConfig {
            reach_distance: 0.03,
            goal_frame: GoalFrame::Relative,
            object_order: ObjectOrder::Turn,
            mirror: 0.5,
            exchange: 0.5,
            ..paper.relay
        },
        exploration: ExplorationConfig {
            random_steps: if single { 1.0 } else { 4.0 },
            window: if single { paper.exploration.window } else { 5 },
            ..paper.exploration
        },
        replay: ReplayConfig {
            batch_size: 128,
            focus: if single { 0.0 } else { 0.5 },
            batch_mode: BatchMode::Joint,
            updates_per_episode: if single { 80 } else { 20 },
            warmup_episodes: 0,
            ..paper.replay
        },
        agent: AgentConfig {
            init: paper.agent.init,
            critic_layer_norm: !single,
            discount: 0.95,
            action_l2: if single { 1.0 } else { 0.1 },
            imitation: 1.0,
            ..AgentConfig::td3()
        },
        evaluation: EvaluationConfig {
            every_episodes: if single { 50 } else { 100 },
            ..paper.evaluation
        },
        ..paper
    }
}

/// As `fast`, with twice the updates, or for more objects with eight times as many.
fn sample_efficient(paper: TrainConfig, objects: usize) -> TrainConfig {
    let fast = fast(paper, objects);
    TrainConfig {
        preset: Preset::SampleEfficient,
        replay: ReplayConfig { updates_per_episode: 160, ..fast.replay },
        ..fast
    }
}
