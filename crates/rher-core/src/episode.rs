//! One episode, and how it is made.

use crate::env::{Env, EnvError, Start};
use crate::goal::{Achieved, Desired};

/// `T + 1` frames, and the `T` actions between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode<const N: usize> {
    /// What the task asked for.
    pub desired: Desired<N>,
    /// `[T + 1, observation]`, raw.
    pub observations: Vec<f32>,
    /// `[T + 1]`.
    pub achieved: Vec<Achieved<N>>,
    /// `[T, action]`, as they were chosen: the environment gets them clipped to [−1, 1].
    pub actions: Vec<f32>,
}

impl<const N: usize> Episode<N> {
    /// How many numbers of its actions were clipped.
    pub fn clipped(&self) -> usize {
        self.actions.iter().filter(|number| number.abs() > 1.0).count()
    }
}

/// What can be known when the next action is chosen.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, const N: usize> {
    /// Raw observation.
    pub observation: &'a [f32],
    /// Where everything is.
    pub achieved: &'a Achieved<N>,
    /// What the task asks for.
    pub desired: &'a Desired<N>,
}

/// An episode could not be played to its end.
#[derive(Debug, thiserror::Error)]
pub enum RolloutError {
    /// The environment itself failed.
    #[error("the environment failed at step {step} of the episode with seed {seed}")]
    Env {
        /// Seed of the episode.
        seed: u64,
        /// Steps taken before.
        step: usize,
        /// What it said.
        source: EnvError,
    },
    /// The environment returned something that is not a number.
    #[error(
        "the environment returned {value} in {place} at step {step} of the episode with seed \
         {seed}, expected finite numbers"
    )]
    NotFinite {
        /// Seed of the episode.
        seed: u64,
        /// Steps taken before.
        step: usize,
        /// Such as `observation[3]`.
        place: String,
        /// NaN or an infinity.
        value: f32,
    },
}

/// Plays one episode of `env`; `act` writes each action.
pub fn rollout<const N: usize>(
    env: &mut impl Env<N>,
    seed: u64,
    mut act: impl FnMut(View<'_, N>, &mut [f32]),
) -> Result<Episode<N>, RolloutError> {
    let (observation, action, steps) = {
        let spec = env.spec();
        (spec.obs_dim, spec.action_dim, spec.episode_steps)
    };
    let mut observations = vec![0.0; (steps + 1) * observation];
    let mut actions = vec![0.0; steps * action];
    let mut clipped = vec![0.0; action];
    let mut achieved = Vec::with_capacity(steps + 1);
    let failed = |step| move |source| RolloutError::Env { seed, step, source };

    let first = &mut observations[..observation];
    let Start { achieved: now, desired } = env.reset(seed, first).map_err(failed(0))?;
    check(first, &now, seed, 0)?;
    achieved.push(now);
    for step in 0..steps {
        let (before, after) = observations.split_at_mut((step + 1) * observation);
        let view = View {
            observation: &before[step * observation..],
            achieved: &achieved[step],
            desired: &desired,
        };
        let action = &mut actions[step * action..(step + 1) * action];
        act(view, action);
        for (clipped, chosen) in clipped.iter_mut().zip(action) {
            *clipped = chosen.clamp(-1.0, 1.0);
        }
        let next = &mut after[..observation];
        let now = env.step(&clipped, next).map_err(failed(step))?;
        check(next, &now, seed, step + 1)?;
        achieved.push(now);
    }
    Ok(Episode { desired, observations, achieved, actions })
}

fn check<const N: usize>(
    observation: &[f32],
    achieved: &Achieved<N>,
    seed: u64,
    step: usize,
) -> Result<(), RolloutError> {
    let not_finite = |place, value| Err(RolloutError::NotFinite { seed, step, place, value });
    if let Some(index) = observation.iter().position(|x| !x.is_finite()) {
        return not_finite(format!("observation[{index}]"), observation[index]);
    }
    let scene = &achieved.0;
    let gripper = std::iter::once(("the gripper's position".to_owned(), &scene.gripper));
    let objects = scene.objects.iter().enumerate();
    let objects = objects.map(|(i, p)| (format!("the position of object {}", i + 1), p));
    if scene.is_finite() {
        return Ok(());
    }
    for (place, position) in gripper.chain(objects) {
        if let Some(value) = position.iter().find(|x| !x.is_finite()) {
            return not_finite(place, *value);
        }
    }
    Ok(())
}
