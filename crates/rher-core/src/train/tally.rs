//! Sums over the training between two evaluations.

use crate::episode::Episode;
use crate::evaluate::Evaluation;
use crate::event::{Metrics, Progress, Seconds, SourceShares};
use crate::explore::ActionSource;
use crate::goal::{EncodedGoal, Stage, Tolerances};
use crate::learner::engine::Losses;
use serde::{Deserialize, Serialize};

/// Sums over the training between two evaluations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Tally {
    episodes: u64,
    successes: u64,
    actors: SourceCounts,
    moved: Vec<u64>,
    batches: Vec<u64>,
    single_reward: Vec<u64>,
    critic_updates: u64,
    actor_updates: u64,
    critic_loss: f64,
    actor_loss: f64,
    q_mean: f64,
    q_min: f32,
    q_max: f32,
    critic_gradient: f64,
    actor_gradient: f64,
}

/// How many actions each kind of actor chose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct SourceCounts {
    guide: u64,
    learner: u64,
    random: u64,
}

impl SourceCounts {
    pub(super) fn count(&mut self, source: ActionSource) {
        match source {
            ActionSource::Guide => self.guide += 1,
            ActionSource::Learner => self.learner += 1,
            ActionSource::Random => self.random += 1,
        }
    }
}

impl Tally {
    pub(super) fn new(subtasks: usize, objects: usize) -> Self {
        Self {
            episodes: 0,
            successes: 0,
            actors: SourceCounts::default(),
            moved: vec![0; objects],
            batches: vec![0; subtasks],
            single_reward: vec![0; subtasks],
            critic_updates: 0,
            actor_updates: 0,
            critic_loss: 0.0,
            actor_loss: 0.0,
            q_mean: 0.0,
            q_min: f32::MAX,
            q_max: f32::MIN,
            critic_gradient: 0.0,
            actor_gradient: 0.0,
        }
    }

    pub(super) fn subtasks(&self) -> usize {
        self.batches.len().min(self.single_reward.len())
    }

    pub(super) fn objects(&self) -> usize {
        self.moved.len()
    }

    pub(super) fn clear(&mut self) {
        *self = Self::new(self.batches.len(), self.moved.len());
    }

    pub(super) fn episode<const N: usize>(
        &mut self,
        episode: &Episode<N>,
        actors: SourceCounts,
        last: Stage<N>,
        tolerances: &Tolerances<N>,
    ) {
        let Episode { desired, achieved, .. } = episode;
        let end = &achieved[achieved.len() - 1];
        let met = EncodedGoal::new(last, end, desired).is_met(end, tolerances);
        self.episodes += 1;
        self.successes += u64::from(met);
        self.actors.guide += actors.guide;
        self.actors.learner += actors.learner;
        self.actors.random += actors.random;
        for (object, moved) in self.moved.iter_mut().enumerate() {
            let start = &achieved[0].0;
            *moved += u64::from(achieved.iter().any(|frame| frame.0.has_moved(object, start)));
        }
    }

    pub(super) fn batch<const N: usize>(&mut self, stage: Stage<N>, rewarded: usize, rows: usize) {
        self.batches[stage.index()] += 1;
        self.single_reward[stage.index()] += u64::from(rewarded == 0 || rewarded == rows);
    }

    pub(super) fn update(&mut self, losses: &Losses) {
        self.critic_updates += 1;
        self.critic_loss += f64::from(losses.critic);
        self.critic_gradient += f64::from(losses.critic_gradient);
        self.q_mean += f64::from(losses.q_mean);
        self.q_min = self.q_min.min(losses.q_min);
        self.q_max = self.q_max.max(losses.q_max);
        if let (Some(loss), Some(gradient)) = (losses.actor, losses.actor_gradient) {
            self.actor_updates += 1;
            self.actor_loss += f64::from(loss);
            self.actor_gradient += f64::from(gradient);
        }
    }

    /// The line of metrics for an evaluation at this point of the run; `guide` is counted from 0.
    pub(super) fn metrics(
        &self,
        progress: Progress,
        guide: usize,
        time: Seconds,
        wall_s: f64,
        evaluation: &Evaluation,
    ) -> Metrics {
        let Progress { env_steps, episodes, updates } = progress;
        let SourceCounts { guide: guided, learner, random } = self.actors;
        let steps = guided + learner + random;
        let critic = |sum: f64| mean(sum, self.critic_updates);
        let actor = |sum: f64| mean(sum, self.actor_updates);
        let trained = self.critic_updates > 0;
        Metrics {
            env_steps,
            episodes,
            updates,
            wall_s,
            success: evaluation.success.clone(),
            success_final: evaluation.success_final,
            guide: guide + 1,
            final_distance: evaluation.final_distance,
            train_success: share(self.successes, self.episodes),
            acted: SourceShares {
                guide: share(guided, steps),
                learner: share(learner, steps),
                random: share(random, steps),
            },
            moved: self.moved.iter().map(|&moved| share(moved, self.episodes)).collect(),
            single_reward: self
                .single_reward
                .iter()
                .zip(&self.batches)
                .map(|(&single, &batches)| (batches > 0).then(|| share(single, batches)))
                .collect(),
            critic_loss: critic(self.critic_loss),
            actor_loss: actor(self.actor_loss),
            q_mean: critic(self.q_mean),
            q_min: if trained { self.q_min } else { 0.0 },
            q_max: if trained { self.q_max } else { 0.0 },
            critic_gradient: critic(self.critic_gradient),
            actor_gradient: actor(self.actor_gradient),
            time,
        }
    }
}

fn mean(sum: f64, count: u64) -> f32 {
    if count == 0 { 0.0 } else { (sum / count as f64) as f32 }
}

fn share(part: u64, whole: u64) -> f32 {
    mean(part as f64, whole)
}
