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

/// What a stop left undone after the last episodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Pending {
    /// Nothing: the next episodes follow.
    #[default]
    Nothing,
    /// All updates but the first `done`, and what follows them.
    Updates {
        /// Updates that were made.
        done: u64,
    },
    /// The evaluation.
    Evaluation,
}

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
    #[serde(with = "crate::since_6")]
    pub(super) pending: Pending,
}

impl RunState {
    /// Whether its parts fit each other; those of a damaged file need not.
    pub(super) fn check(&self) -> Result<(), String> {
        let Self { config, info, encoder, curriculum, tally, .. } = self;
        config.validate().map_err(|error| error.to_string())?;
        let PolicyInfo { objects, subtasks, untrained, obs_dim, .. } = *info;
        if subtasks > objects.saturating_mul(2) || untrained >= subtasks {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Preset;
    use crate::env::Env as _;
    use crate::seed::{Purpose, Seed};
    use crate::testing::Carry;

    fn whole() -> (RunState, LearnerState) {
        let mut config = Preset::Fast.config("carry", 1);
        config.agent.hidden = vec![4, 4];
        let env = Carry::new();
        let spec = env.spec();
        let encoder = InputEncoder::new(&config.relay, spec);
        let mut rng = Seed(1).stream(Purpose::Init, 0);
        let learner = LearnerState::new(&config.agent, encoder.width(), spec.action_dim, &mut rng);
        let info = PolicyInfo {
            task: spec.name.clone(),
            variant: String::new(),
            objects: 1,
            subtasks: 2,
            untrained: 1,
            obs_dim: spec.obs_dim,
            action_dim: spec.action_dim,
            reach_distance: config.relay.reach_distance,
        };
        let state = RunState {
            env_steps: 0,
            episodes: 0,
            updates: 0,
            evaluations: 0,
            last_success: [0.0; 2],
            curriculum: Curriculum::new(&config.exploration, 2),
            tally: Tally::new(2, 1),
            wall_s: 0.0,
            seconds: Seconds::default(),
            pending: Pending::Nothing,
            encoder,
            info,
            config,
        };
        (state, learner)
    }

    fn check(state: &RunState, learner: &LearnerState) -> Result<(), String> {
        state.check().and_then(|()| state.check_learner(learner))
    }

    #[test]
    fn parts_that_do_not_fit_each_other_are_refused() {
        let (state, learner) = whole();
        assert_eq!(check(&state, &learner), Ok(()));
        let damages: &[fn(&mut RunState, &mut LearnerState)] = &[
            |state, _| state.config.replay.batch_size = 0,
            |state, _| state.info.objects = 2,
            |state, _| state.info.subtasks = 1,
            |state, _| state.info.untrained = 2,
            |state, _| state.info.obs_dim += 1,
            |state, _| state.info.action_dim += 1,
            |state, _| state.curriculum = Curriculum::new(&state.config.exploration, 1),
            |state, _| state.tally = Tally::new(1, 1),
            |state, _| state.tally = Tally::new(2, 2),
            |state, _| {
                // Two sub-tasks for each object, but this many in every part.
                state.info.subtasks = 3;
                state.curriculum = Curriculum::new(&state.config.exploration, 3);
                state.tally = Tally::new(3, 1);
            },
            |state, _| state.config.agent.hidden = vec![4],
            |state, _| state.config.agent.critic_layer_norm = !state.config.agent.critic_layer_norm,
            |_, learner| learner.critics.truncate(1),
            |_, learner| learner.actor.shape.layer_norm = true,
            |_, learner| learner.critics[0].shape.hidden[1] = 5,
            |_, learner| learner.actor.online.truncate(1),
            |_, learner| learner.actor.target.truncate(1),
            |_, learner| learner.critics[1].first_moment.push(0.0),
            |_, learner| learner.critics[1].second_moment.clear(),
        ];
        for (index, damage) in damages.iter().enumerate() {
            let (mut state, mut learner) = whole();
            damage(&mut state, &mut learner);
            assert!(check(&state, &learner).is_err(), "damage {index}");
        }
    }
}
