//! Plays an episode of training: chooses who acts, and acts.

use super::in_order::InOrder;
use crate::env::Env;
use crate::episode::{Episode, RolloutError, rollout};
use crate::explore::{ActionSource, Explorer, Selection};
use crate::goal::{Stage, Tolerances};
use crate::normal::StandardNormal;
use crate::policy::Policy;
use crate::seed::{Purpose, Seed};
use rand::RngExt as _;
use std::time::{Duration, Instant};

/// Share of the episodes that take their objects in the order that promises most, once that is
/// known; the others, in the given order, show what became of the orders that do not.
const CHOSEN: f32 = 0.8;

/// A training episode and what it took.
pub(super) struct Played<const N: usize> {
    /// Seed of its environment.
    pub(super) seed: u64,
    pub(super) episode: Episode<N>,
    /// `[T]`.
    pub(super) choices: Vec<Selection<N>>,
    /// Choosing actions.
    pub(super) acting: Duration,
    /// All of it.
    pub(super) playing: Duration,
}

/// Plays one episode with actions chosen by eq. 10, and notes who acted.
pub(super) fn explore_once<const N: usize>(
    env: &mut impl Env<N>,
    policy: &Policy,
    guide: &Explorer<N>,
    tolerances: &Tolerances<N>,
    seed: Seed,
    episode: u64,
) -> Result<Played<N>, RolloutError> {
    let started = Instant::now();
    let mut acting = Duration::ZERO;
    let reach_distance = policy.info().reach_distance;
    let mut rng = seed.stream(Purpose::Exploration, episode);
    let mut actor = policy.actor(env.spec()).expect("the policy was made for this environment");
    let mut choices = Vec::with_capacity(env.spec().episode_steps);
    let mut kept = vec![0.0; env.spec().action_dim];
    let env_seed = seed.episode(Purpose::Environment, episode);
    // Draws nothing where there is no choice.
    let model = policy.encoder().order().filter(|_| rng.random::<f32>() < CHOSEN);
    let mut env = InOrder::new(env, model);
    let episode = rollout(&mut env, env_seed, |view, action| {
        let asked = Instant::now();
        let stage = Stage::of(view.achieved, view.desired, tolerances, reach_distance);
        let random =
            choices.last().is_some_and(|last: &Selection<N>| last.source == ActionSource::Random);
        if random && guide.keeps_random(&mut rng) {
            choices.push(Selection { source: ActionSource::Random, stage: guide.learner(stage) });
            action.copy_from_slice(&kept);
            acting += asked.elapsed();
            return Ok(());
        }
        let choice = guide.draw(stage, &mut rng);
        choices.push(choice);
        let Selection { source, stage } = choice;
        match source {
            ActionSource::Random => {
                action.fill_with(|| rng.random_range(-1.0..=1.0));
                kept.copy_from_slice(action);
            }
            ActionSource::Guide | ActionSource::Learner => {
                actor.act(stage, view.observation, view.achieved, view.desired, action)?;
                let deviation = guide.noise(stage);
                for action in action {
                    let draw: f32 = rng.sample(StandardNormal);
                    *action += deviation * draw;
                }
            }
        }
        acting += asked.elapsed();
        Ok(())
    })?;
    Ok(Played { seed: env_seed, episode, choices, acting, playing: started.elapsed() })
}
