//! Everything of a run but its replay and its learner.

use super::tally::Tally;
use crate::config::TrainConfig;
use crate::event::Seconds;
use crate::explore::Curriculum;
use crate::input::InputEncoder;
use crate::learner::network::Shape;
use crate::learner::state::{LearnerState, Trained};
use crate::policy::PolicyInfo;
use serde::{Deserialize, Serialize};

/// Everything of a run but its replay: what a checkpoint keeps beside it.
///
/// There are no generator states in it: random streams are functions of the counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct RunState {
    pub(super) config: TrainConfig,
    pub(super) info: PolicyInfo,
    pub(super) env_steps: u64,
    pub(super) episodes: u64,
    pub(super) updates: u64,
    pub(super) evaluations: u64,
    /// Final success rates of the last two evaluations, the newest last.
    pub(super) last_success: [f32; 2],
    pub(super) encoder: InputEncoder,
    pub(super) curriculum: Curriculum,
    pub(super) tally: Tally,
    pub(super) wall_s: f64,
    pub(super) seconds: Seconds,
}

impl RunState {
    /// Whether its parts fit each other; those of a damaged file need not.
    pub(super) fn check(&self) -> Result<(), String> {
        let Self { config, info, encoder, curriculum, tally, .. } = self;
        config.validate().map_err(|error| error.to_string())?;
        let PolicyInfo { objects, subtasks, untrained, obs_dim, .. } = *info;
        if objects == 0 || subtasks > objects.saturating_mul(2) || untrained >= subtasks {
            return Err(format!(
                "{subtasks} sub-tasks, {untrained} of them untrained, for {objects} objects"
            ));
        }
        encoder.check()?;
        let facts = [
            ("observation", encoder.observation(), obs_dim),
            ("objects", encoder.objects(), objects),
            ("sub-tasks", curriculum.subtasks(), subtasks),
            ("sub-tasks", tally.subtasks(), subtasks),
            ("objects", tally.objects(), objects),
        ];
        check(&facts)
    }

    /// Whether the networks of `learner` are those of the settings.
    pub(super) fn check_learner(&self, learner: &LearnerState) -> Result<(), String> {
        let (agent, info) = (&self.config.agent, &self.info);
        let input = self.encoder.width();
        check(&[("critics", learner.critics.len(), agent.critics)])?;
        let actor = [(&learner.actor, input, info.action_dim, false)];
        let critics = learner
            .critics
            .iter()
            .map(|critic| (critic, input + info.action_dim, 1, agent.critic_layer_norm));
        for (network, inputs, outputs, layer_norm) in actor.into_iter().chain(critics) {
            let expected = Shape { inputs, hidden: agent.hidden.clone(), outputs, layer_norm };
            let Trained { shape, online, target, first_moment, second_moment, .. } = network;
            if *shape != expected {
                return Err(format!("a network is {shape:?}, expected {expected:?}"));
            }
            let parameters = shape.checked_parameters().unwrap_or(usize::MAX);
            for vector in [online, target, first_moment, second_moment] {
                check(&[("parameters", vector.len(), parameters)])?;
            }
        }
        Ok(())
    }
}

/// The first of these facts whose two numbers differ.
fn check(facts: &[(&str, usize, usize)]) -> Result<(), String> {
    match facts.iter().find(|(_, found, expected)| found != expected) {
        Some((what, found, expected)) => Err(format!("{what}: {found}, expected {expected}")),
        None => Ok(()),
    }
}
