//! Many environments of one task, stepped together.

use crate::goals::{RewardKind, achieved_goal};
use crate::layout::Chosen;
use crate::simulated::Simulated;
use crate::threads::Threads;
use rayon::prelude::*;
use rher_core::env::{EnvError, EnvSpec, Start};
use rher_core::goal::{Desired, EncodedGoal, Position};
use rher_core::seed::{Purpose, Seed};
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

/// When an environment starts its next episode.
///
/// The three modes are those of Gymnasium's vector environments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AutoReset {
    /// When [`Pool::reset_where`] says so; a step before that is an error.
    Never,
    /// In the step after its last one, which ignores its action and is rewarded with 0.
    NextStep,
    /// In its last step: the observation is already that of the next episode, and that of the end
    /// is in [`Pool::last`].
    SameStep,
}

/// Environments of one task that are stepped together on threads of their own.
///
/// What they see and get lies in one array for each kind of number, one row for each environment.
/// A step allocates nothing but what the solver and the queue of the threads need, and the number
/// of threads never changes a number. A forked process starts its own threads at its first step.
///
/// ```
/// use rher_envs::{AutoReset, Pool, Simulation, tasks::Push};
///
/// let envs = (0..4).map(|_| Simulation::<Push, 1>::new()).collect();
/// let mut pool = Pool::new(envs, 2, AutoReset::NextStep)?;
/// pool.reset(&[1, 2, 3, 4])?;
/// pool.step(&[0.5; 4 * 4])?;
/// assert_eq!(pool.now().observations.len(), 4 * 25);
/// assert_eq!(pool.rewards().len(), 4);
/// # Ok::<(), rher_envs::PoolError>(())
/// ```
pub struct Pool<E, const N: usize> {
    pub(super) slots: Vec<Slot<E, N>>,
    pub(super) spec: EnvSpec<N>,
    pub(super) auto_reset: AutoReset,
    kind: RewardKind,
    pub(super) threads: Threads,
    pub(super) now: Frames,
    pub(super) last: Frames,
    pub(super) rewards: Vec<f32>,
    pub(super) successes: Vec<bool>,
    pub(super) ended: Vec<bool>,
    pub(super) clipped: Vec<u32>,
}

/// What the environments see, row by row; positions in meters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// `[envs, observation]`.
    pub observations: Vec<f32>,
    /// `[envs, 3 N]`: where the objects are; where the gripper is, if the task is to reach.
    pub achieved: Vec<f32>,
    /// `[envs, 3 N]`: where they should be.
    pub desired: Vec<f32>,
}

impl Frames {
    fn zeros(envs: usize, observation: usize, goal: usize) -> Self {
        let zeros = |width: usize| vec![0.0; envs * width];
        Self { observations: zeros(observation), achieved: zeros(goal), desired: zeros(goal) }
    }
}

/// One environment and how far it is.
pub(super) struct Slot<E, const N: usize> {
    pub(super) env: E,
    /// Seed of its first episode, from which those of the later ones follow.
    pub(super) seed: u64,
    /// Episodes started since.
    pub(super) episodes: u64,
    /// `[steps, action]`: actions of the running episode.
    pub(super) actions: Vec<f32>,
    /// What was chosen of how it began.
    pub(super) chosen: Chosen,
    /// None before the first reset and after a failure.
    pub(super) running: Option<Running<N>>,
    pub(super) failure: Option<EnvError>,
}

/// An episode that was started.
pub(super) struct Running<const N: usize> {
    desired: Desired<N>,
    /// Steps taken.
    step: usize,
}

/// The pool could not be made, reset or stepped.
#[derive(Debug, thiserror::Error)]
pub enum PoolError {
    /// There is nothing to step.
    #[error("a pool needs at least one environment")]
    Empty,
    /// The threads could not be started.
    #[error("cannot start {threads} threads")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system said.
        source: rayon::ThreadPoolBuildError,
    },
    /// An array is too long or too short.
    #[error("{what}: {got} numbers, expected {expected} for {envs} environments")]
    Length {
        /// Which array.
        what: &'static str,
        /// Environments in the pool.
        envs: usize,
        /// Numbers they need.
        expected: usize,
        /// Numbers that came.
        got: usize,
    },
    /// An action is not a number; no environment has moved.
    #[error("number {index} of the action of environment {env} is NaN")]
    NotANumber {
        /// Row of the environment.
        env: usize,
        /// Place in its action.
        index: usize,
    },
    /// An environment would have to act outside of an episode; none has moved.
    #[error("environment {env} has to be reset before it can be stepped")]
    NotReset {
        /// Row of the environment.
        env: usize,
    },
    /// An environment failed.
    #[error("environment {env} failed")]
    Env {
        /// Row of the environment.
        env: usize,
        /// What it said.
        source: EnvError,
    },
}

impl<E: Simulated<N>, const N: usize> Pool<E, N> {
    /// A pool of `envs`, which are equal, stepped by as many `threads`.
    pub fn new(envs: Vec<E>, threads: usize, auto_reset: AutoReset) -> Result<Self, PoolError> {
        let count = envs.len();
        let spec = envs.first().ok_or(PoolError::Empty)?.spec().clone();
        let threads =
            Threads::new(threads).map_err(|source| PoolError::Threads { threads, source })?;
        let slot = |env| {
            let (actions, chosen) = (Vec::new(), Chosen::default());
            Slot { env, seed: 0, episodes: 0, actions, chosen, running: None, failure: None }
        };
        Ok(Self {
            slots: envs.into_iter().map(slot).collect(),
            auto_reset,
            kind: RewardKind::Sparse,
            threads,
            now: Frames::zeros(count, spec.obs_dim, 3 * N),
            last: Frames::zeros(count, spec.obs_dim, 3 * N),
            rewards: vec![0.0; count],
            successes: vec![false; count],
            ended: vec![false; count],
            clipped: vec![0; count],
            spec,
        })
    }

    /// Ends episodes after this number of steps instead of that of the environments.
    #[must_use]
    pub fn with_episode_steps(mut self, steps: NonZeroUsize) -> Self {
        self.spec.episode_steps = steps.get();
        self
    }

    /// Rewards steps by this instead of [`RewardKind::Sparse`].
    #[must_use]
    pub fn with_rewards(mut self, kind: RewardKind) -> Self {
        self.kind = kind;
        self
    }

    /// Widths and limits of each environment.
    pub fn spec(&self) -> &EnvSpec<N> {
        &self.spec
    }

    /// How many environments there are.
    pub fn envs(&self) -> usize {
        self.slots.len()
    }

    /// Starts an episode in every environment, each with its own seed.
    ///
    /// Later episodes have seeds that follow from it and from their count.
    pub fn reset(&mut self, seeds: &[u64]) -> Result<(), PoolError> {
        self.seed(seeds)?;
        self.each(|_, row| row.start(Chosen::default()))
    }

    /// Gives every environment a seed, with which its next episode starts.
    pub fn seed(&mut self, seeds: &[u64]) -> Result<(), PoolError> {
        self.check_length("seeds", seeds.len(), 1)?;
        for (slot, seed) in self.slots.iter_mut().zip(seeds) {
            (slot.seed, slot.episodes) = (*seed, 0);
        }
        Ok(())
    }

    /// Starts the next episode in every environment that `mask` marks.
    pub fn reset_where(&mut self, mask: &[bool]) -> Result<(), PoolError> {
        self.reset_with(mask, &vec![Chosen::default(); self.envs()])
    }

    /// Starts the next episode in every environment that `mask` marks, with what is `chosen` for it;
    /// the episodes that follow are drawn.
    pub fn reset_with(&mut self, mask: &[bool], chosen: &[Chosen]) -> Result<(), PoolError> {
        self.check_length("mask", mask.len(), 1)?;
        self.check_length("what is chosen", chosen.len(), 1)?;
        self.each(|env, row| if mask[env] { row.start(chosen[env].clone()) } else { Ok(()) })
    }

    /// The environment of a row, to look at: what was done to it is undone before the next step.
    /// `None` before its first reset and after a failure.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    pub fn env_mut(&mut self, row: usize) -> Option<&mut E> {
        let Slot { env, running, .. } = &mut self.slots[row];
        running.as_ref().map(|_| env)
    }

    /// Acts in every environment for one step.
    ///
    /// # Shapes
    ///
    /// `actions`: `[envs, action]`. Numbers outside of [−1, 1] are clipped, and counted in
    /// [`clipped`](Self::clipped).
    pub fn step(&mut self, actions: &[f32]) -> Result<(), PoolError> {
        let width = self.spec.action_dim;
        self.check_length("actions", actions.len(), width)?;
        if let Some(place) = actions.iter().position(|x| x.is_nan()) {
            return Err(PoolError::NotANumber { env: place / width, index: place % width });
        }
        let steps = self.spec.episode_steps;
        let may_end = self.auto_reset != AutoReset::Never;
        let can_step = |slot: &Slot<E, N>| {
            slot.running.as_ref().is_some_and(|running| running.step < steps || may_end)
        };
        if let Some(env) = self.slots.iter().position(|slot| !can_step(slot)) {
            return Err(PoolError::NotReset { env });
        }
        let auto_reset = self.auto_reset;
        self.each(|env, row| {
            if row.is_over() {
                return row.start(Chosen::default());
            }
            row.act(&actions[env * width..(env + 1) * width])?;
            if *row.ended && auto_reset == AutoReset::SameStep {
                row.keep();
                row.begin(Chosen::default())?;
            }
            Ok(())
        })
    }

    /// What the environments see now.
    pub fn now(&self) -> &Frames {
        &self.now
    }

    /// What they saw at the end of their last episode, with [`AutoReset::SameStep`].
    pub fn last(&self) -> &Frames {
        &self.last
    }

    /// `[envs]`: reward of the last step for the last sub-task.
    pub fn rewards(&self) -> &[f32] {
        &self.rewards
    }

    /// `[envs]`: whether the last sub-task was met after the last step.
    pub fn successes(&self) -> &[bool] {
        &self.successes
    }

    /// `[envs]`: whether the last step was the last of its episode.
    pub fn ended(&self) -> &[bool] {
        &self.ended
    }

    /// `[envs]`: numbers of this episode's actions that were clipped; of the episode that ended
    /// where one did.
    pub fn clipped(&self) -> &[u32] {
        &self.clipped
    }

    pub(super) fn check_length(
        &self,
        what: &'static str,
        got: usize,
        width: usize,
    ) -> Result<(), PoolError> {
        let envs = self.envs();
        let expected = envs * width;
        if got == expected { Ok(()) } else { Err(PoolError::Length { what, envs, expected, got }) }
    }

    /// Does `work` for every environment; of several failures the first one is told.
    pub(super) fn each(
        &mut self,
        work: impl Fn(usize, &mut Row<'_, E, N>) -> Result<(), EnvError> + Sync,
    ) -> Result<(), PoolError> {
        let Self { slots, spec, kind, threads, now, last, .. } = self;
        let Self { rewards, successes, ended, clipped, .. } = self;
        let count = threads.count();
        let threads =
            threads.here().map_err(|source| PoolError::Threads { threads: count, source })?;
        let (observation, goal) = (spec.obs_dim, 3 * N);
        let rows = (
            slots.par_iter_mut(),
            now.observations.par_chunks_exact_mut(observation),
            now.achieved.par_chunks_exact_mut(goal),
            now.desired.par_chunks_exact_mut(goal),
            last.observations.par_chunks_exact_mut(observation),
            last.achieved.par_chunks_exact_mut(goal),
            last.desired.par_chunks_exact_mut(goal),
            rewards.par_iter_mut(),
            successes.par_iter_mut(),
            ended.par_iter_mut(),
            clipped.par_iter_mut(),
        );
        let (spec, kind) = (&*spec, *kind);
        threads.install(|| {
            rows.into_par_iter().enumerate().for_each(|(env, row)| {
                let (slot, a, b, c, d, e, f, reward, success, ended, clipped) = row;
                let (now, last) = ((a, b, c), (d, e, f));
                let mut row = Row { slot, spec, kind, now, last, reward, success, ended, clipped };
                if let Err(failure) = work(env, &mut row) {
                    row.slot.running = None;
                    row.slot.failure = Some(failure);
                }
            });
        });
        let mut failed = self.slots.iter_mut().enumerate();
        match failed.find_map(|(env, slot)| Some((env, slot.failure.take()?))) {
            Some((env, source)) => Err(PoolError::Env { env, source }),
            None => Ok(()),
        }
    }
}

/// Observation, achieved and desired goal of one environment.
type FrameRow<'a> = (&'a mut [f32], &'a mut [f32], &'a mut [f32]);

/// One environment and its row of every array.
pub(super) struct Row<'a, E, const N: usize> {
    pub(super) slot: &'a mut Slot<E, N>,
    spec: &'a EnvSpec<N>,
    kind: RewardKind,
    now: FrameRow<'a>,
    last: FrameRow<'a>,
    reward: &'a mut f32,
    success: &'a mut bool,
    ended: &'a mut bool,
    clipped: &'a mut u32,
}

impl<E: Simulated<N>, const N: usize> Row<'_, E, N> {
    /// Starts the next episode, as a step of its own.
    fn start(&mut self, chosen: Chosen) -> Result<(), EnvError> {
        *self.reward = 0.0;
        *self.success = false;
        *self.ended = false;
        self.begin(chosen)
    }

    /// Starts the next episode.
    pub(super) fn begin(&mut self, chosen: Chosen) -> Result<(), EnvError> {
        let Slot { env, seed, episodes, actions, chosen: kept, running, .. } = self.slot;
        actions.clear();
        let seed = match *episodes {
            0 => *seed,
            count => Seed(*seed).episode(Purpose::Environment, count),
        };
        *episodes += 1;
        let Start { achieved, desired } = env.reset_with(seed, &chosen, self.now.0)?;
        *kept = chosen;
        *running = Some(Running { desired, step: 0 });
        write(&achieved_goal(self.spec, &achieved), self.now.1);
        write(desired.objects(), self.now.2);
        Ok(())
    }

    /// Whether the episode has had its last step.
    fn is_over(&self) -> bool {
        let steps = self.spec.episode_steps;
        self.slot.running.as_ref().is_some_and(|running| running.step == steps)
    }

    /// Acts for one step of an episode that was started.
    pub(super) fn act(&mut self, action: &[f32]) -> Result<(), EnvError> {
        let Slot { env, actions, running, .. } = self.slot;
        let Some(Running { desired, step }) = running else { return Ok(()) };
        if *step == 0 {
            *self.clipped = 0;
        }
        *self.clipped += action.iter().filter(|x| x.abs() > 1.0).count() as u32;
        let achieved = env.step(action, self.now.0)?;
        actions.extend_from_slice(action);
        *step += 1;
        *self.ended = *step == self.spec.episode_steps;
        let goal = EncodedGoal::new(self.spec.last_stage(), &achieved, desired);
        *self.reward = self.kind.of_scene(self.spec, &achieved, desired);
        *self.success = goal.is_met(&achieved, &self.spec.tolerances);
        write(&achieved_goal(self.spec, &achieved), self.now.1);
        Ok(())
    }

    /// Keeps what is seen now as the end of an episode.
    fn keep(&mut self) {
        self.last.0.copy_from_slice(self.now.0);
        self.last.1.copy_from_slice(self.now.1);
        self.last.2.copy_from_slice(self.now.2);
    }
}

fn write<const N: usize>(positions: &[Position; N], row: &mut [f32]) {
    for (position, out) in positions.iter().zip(row.chunks_exact_mut(3)) {
        out.copy_from_slice(position.coords.as_slice());
    }
}
