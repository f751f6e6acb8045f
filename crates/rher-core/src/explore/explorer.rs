//! Who chooses the next action (eq. 10).

use super::Curriculum;
use crate::config::{ExplorationConfig, Method, TrainConfig, TrainPolicy};
use crate::goal::Stage;
use rand::{Rng, RngExt as _};
use serde::{Deserialize, Serialize};

/// Who chooses an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ActionSource {
    /// The policy of a sub-task that leads to where the learner can learn.
    Guide,
    /// The policy that is to be learned there, or that the episode is for.
    Learner,
    /// Chance: a uniform draw.
    Random,
}

/// Who chooses an action, and for what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection<const N: usize> {
    /// Who.
    pub source: ActionSource,
    /// The sub-task whose policy it is; where chance chooses, the one that is to be learned.
    pub stage: Stage<N>,
}

/// Draws who chooses each action of an episode.
#[derive(Clone, Debug)]
pub struct Explorer<const N: usize> {
    config: ExplorationConfig,
    method: Method,
    leading: usize,
    last: usize,
    rates: Vec<f32>,
}

impl<const N: usize> Explorer<N> {
    /// The draw as the curriculum has it now.
    pub fn new(config: &TrainConfig, subtasks: usize, curriculum: &Curriculum) -> Self {
        Self {
            config: config.exploration.clone(),
            method: config.relay.method,
            leading: curriculum.guide(),
            last: subtasks - 1,
            rates: (0..subtasks).map(|subtask| curriculum.rate(subtask)).collect(),
        }
    }

    /// Draws who chooses the action in a scene at `stage` (eq. 10).
    ///
    /// With probability β it is chance, with α the policy of sub-task max(g, j), otherwise the one
    /// after it. Where both are the last sub-task it counts as the learner.
    pub fn draw(&self, stage: Stage<N>, rng: &mut impl Rng) -> Selection<N> {
        let first = self.first(stage);
        let learner = self.learner(stage);
        let guided = self.method == Method::Rher && first < learner.index();

        // Actions that are kept count as well: new ones are drawn less often, and among the steps
        // that are left the guide and the learner keep their shares of all.
        let share = self.config.random * self.exploration(learner.index());
        let steps = self.config.random_steps;
        let random = share / (steps - share * (steps - 1.0));
        let guide = match self.config.train_policy {
            TrainPolicy::Mix => self.config.guide * ((1.0 - random) / (1.0 - share)),
            TrainPolicy::Guide => 1.0,
        };
        let draw = rng.random::<f32>();
        if draw < random {
            Selection { source: ActionSource::Random, stage: learner }
        } else if guided && draw < random + guide {
            let stage = Stage::from_index(first).unwrap_or(stage);
            Selection { source: ActionSource::Guide, stage }
        } else {
            Selection { source: ActionSource::Learner, stage: learner }
        }
    }

    /// Whether the random action of the last step is kept for one more.
    pub fn keeps_random(&self, rng: &mut impl Rng) -> bool {
        self.config.random_steps > 1.0 && rng.random::<f32>() >= 1.0 / self.config.random_steps
    }

    /// The sub-task that is to be learned in a scene at `stage`.
    pub fn learner(&self, stage: Stage<N>) -> Stage<N> {
        let index = match self.method {
            Method::Rher => (self.first(stage) + 1).min(self.last),
            Method::Her => self.last,
        };
        Stage::from_index(index).unwrap_or(stage)
    }

    /// Index of the sub-task max(g, j), whose policy guides.
    fn first(&self, stage: Stage<N>) -> usize {
        self.leading.max(stage.index()).min(self.last)
    }

    /// Standard deviation of the noise on an action of the policy of `stage`.
    pub fn noise(&self, stage: Stage<N>) -> f32 {
        self.config.noise * self.exploration(stage.index())
    }

    /// What is left to explore in a sub-task: 1, or 1 − its success rate (AAES).
    fn exploration(&self, subtask: usize) -> f32 {
        if self.config.adjust_to_success { 1.0 - self.rates[subtask] } else { 1.0 }
    }
}
