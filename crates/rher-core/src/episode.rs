//! One episode, and how it is made.

use crate::env::{End, Env, EnvError, Permutation, SignedIndex, Start};
use crate::goal::{Achieved, Desired, TAIL_NUMBERS};

/// `T + 1` frames, and the `T` actions between them; `T` is [`EnvSpec::episode_steps`], or less where
/// the environment ended the episode before.
///
/// [`EnvSpec::episode_steps`]: crate::EnvSpec::episode_steps
///
/// ```
/// use rher_core::testing::Carry;
/// use rher_core::{Episode, rollout};
///
/// let episode: Episode<1> = rollout(&mut Carry::new(), 1, |view, action| {
///     action.copy_from_slice(&[view.achieved.0.objects[0].x - view.achieved.0.gripper.x, 1.0]);
///     Ok(())
/// })?;
/// assert_eq!((episode.achieved.len(), episode.actions.len()), (21, 2 * 20));
/// # Ok::<(), rher_core::RolloutError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Episode<const N: usize> {
    /// What the task asked for.
    pub desired: Desired<N>,
    /// `[T + 1, obs_dim]`, raw.
    pub observations: Vec<f32>,
    /// `[T + 1]`.
    pub achieved: Vec<Achieved<N>>,
    /// `[T, action_dim]`, as they were carried out: each number in [−1, 1].
    pub actions: Vec<f32>,
    /// How it ended.
    pub end: End,
}

impl<const N: usize> Episode<N> {
    /// Steps that were taken, T.
    pub fn steps(&self) -> usize {
        self.achieved.len() - 1
    }

    /// The same episode with its objects in another order.
    #[must_use]
    pub fn reordered(&self, permutation: &Permutation<N>) -> Self {
        let Permutation { order, observation: images } = permutation;
        let mut observations = vec![0.0; self.observations.len()];
        let frames = self.observations.chunks_exact(images.len());
        for (image, frame) in observations.chunks_exact_mut(images.len()).zip(frames) {
            SignedIndex::apply(images, frame, image);
        }
        let achieved = self.achieved.iter().map(|now| Achieved(now.0.reordered(order)));
        Self {
            desired: self.desired.reordered(order),
            observations,
            achieved: achieved.collect(),
            actions: self.actions.clone(),
            end: self.end,
        }
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

/// No action could be chosen.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ActError {
    /// A slice has the wrong length.
    #[error("`{field}` has {given} numbers, expected {expected}")]
    Length {
        /// `observation` or `action`.
        field: &'static str,
        /// Length that the policy takes.
        expected: usize,
        /// Length that was given.
        given: usize,
    },
    /// A number is NaN or infinite.
    #[error("number {index} of `{field}` is {value}, expected a finite number")]
    NotFinite {
        /// `observation`, `achieved` (the gripper's position, then the objects'), `desired`,
        /// `achieved tails` or `desired tails` ([`TAIL_NUMBERS`] for each object), or `action`,
        /// which the policy itself computed.
        field: &'static str,
        /// Place in it, counted from 0.
        index: usize,
        /// NaN or an infinity.
        value: f32,
    },
}

/// An episode could not be played to its end.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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
    /// The policy could not act.
    #[error("no action for step {step} of the episode with seed {seed}")]
    Act {
        /// Seed of the episode.
        seed: u64,
        /// Steps taken before.
        step: usize,
        /// What was wrong.
        source: ActError,
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

/// Plays one episode of `env` until it ends; `act` writes each action, which is then clipped to
/// [−1, 1].
pub fn rollout<const N: usize>(
    env: &mut impl Env<N>,
    seed: u64,
    mut act: impl FnMut(View<'_, N>, &mut [f32]) -> Result<(), ActError>,
) -> Result<Episode<N>, RolloutError> {
    let (observation, action_dim, steps) = {
        let spec = env.spec();
        (spec.obs_dim, spec.action_dim, spec.episode_steps)
    };
    let mut observations = vec![0.0; (steps + 1) * observation];
    let mut actions = vec![0.0; steps * action_dim];
    let mut achieved = Vec::with_capacity(steps + 1);
    let failed = |step| move |source| RolloutError::Env { seed, step, source };

    let first = &mut observations[..observation];
    let Start { achieved: now, desired } = env.reset(seed, first).map_err(failed(0))?;
    check(first, &now, seed, 0)?;
    check_targets(&desired, seed)?;
    achieved.push(now);
    for step in 0..steps {
        let (before, after) = observations.split_at_mut((step + 1) * observation);
        let view = View {
            observation: &before[step * observation..],
            achieved: &achieved[step],
            desired: &desired,
        };
        let action = &mut actions[step * action_dim..(step + 1) * action_dim];
        act(view, action).map_err(|source| RolloutError::Act { seed, step, source })?;
        for number in action.iter_mut() {
            *number = number.clamp(-1.0, 1.0);
        }
        let next = &mut after[..observation];
        let now = env.step(action, next).map_err(failed(step))?;
        check(next, &now, seed, step + 1)?;
        achieved.push(now);
        if let Some(end) = env.end() {
            observations.truncate((step + 2) * observation);
            actions.truncate((step + 1) * action_dim);
            return Ok(Episode { desired, observations, achieved, actions, end });
        }
    }
    Ok(Episode { desired, observations, achieved, actions, end: End::Truncated })
}

fn check_targets<const N: usize>(desired: &Desired<N>, seed: u64) -> Result<(), RolloutError> {
    for (object, target) in desired.objects().iter().enumerate() {
        if let Some(value) = target.iter().find(|x| !x.is_finite()) {
            let place = format!("the target of object {}", object + 1);
            return Err(RolloutError::NotFinite { seed, step: 0, place, value: *value });
        }
    }
    Ok(())
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
    for (object, tail) in scene.tails.all().chunks_exact(TAIL_NUMBERS).enumerate() {
        if let Some(number) = tail.iter().position(|x| !x.is_finite()) {
            let place = format!("number {number} of the tail of object {}", object + 1);
            return not_finite(place, tail[number]);
        }
    }
    Ok(())
}
