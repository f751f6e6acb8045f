//! Environments of one task that are stepped together, the task being known at run time only.

use crate::any_env::read;
use crate::picture::Painter;
use rher_core::env::EnvError;
use rher_core::goal::Desired;
use rher_envs::render::Image;
use rher_envs::{
    AutoReset, Chosen, EnvVisitor, Frames, OptionError, Options, Pool, PoolError, PoolRecord,
    RewardKind, Simulated, Task,
};
use std::num::NonZeroUsize;

/// A [`Pool`], whatever its task.
pub(crate) trait AnyPool: Send {
    fn seed(&mut self, seeds: &[u64]) -> Result<(), PoolError>;

    fn reset_with(&mut self, mask: &[bool], chosen: &[Chosen]) -> Result<(), PoolError>;

    fn step(&mut self, actions: &[f32]) -> Result<(), PoolError>;

    fn now(&self) -> &Frames;

    fn last(&self) -> &Frames;

    fn rewards(&self) -> &[f32];

    fn successes(&self) -> &[bool];

    fn ended(&self) -> &[bool];

    fn record(&self) -> PoolRecord;

    fn play(&mut self, record: &PoolRecord) -> Result<(), PoolError>;

    /// Whether what is seen now solves the task, row by row.
    fn solved(&self) -> Vec<bool>;

    /// A picture of an environment; `None` if no episode is running there.
    fn picture(&mut self, row: usize, painter: &mut Painter) -> Result<Option<Image>, EnvError>;
}

impl<E: Simulated<N>, const N: usize> AnyPool for Pool<E, N> {
    fn seed(&mut self, seeds: &[u64]) -> Result<(), PoolError> {
        Self::seed(self, seeds)
    }

    fn reset_with(&mut self, mask: &[bool], chosen: &[Chosen]) -> Result<(), PoolError> {
        Self::reset_with(self, mask, chosen)
    }

    fn step(&mut self, actions: &[f32]) -> Result<(), PoolError> {
        Self::step(self, actions)
    }

    fn now(&self) -> &Frames {
        Self::now(self)
    }

    fn last(&self) -> &Frames {
        Self::last(self)
    }

    fn rewards(&self) -> &[f32] {
        Self::rewards(self)
    }

    fn successes(&self) -> &[bool] {
        Self::successes(self)
    }

    fn ended(&self) -> &[bool] {
        Self::ended(self)
    }

    fn record(&self) -> PoolRecord {
        Self::record(self)
    }

    fn play(&mut self, record: &PoolRecord) -> Result<(), PoolError> {
        Self::play(self, record)
    }

    fn solved(&self) -> Vec<bool> {
        let Frames { achieved, desired, .. } = Self::now(self);
        let rows = achieved.chunks_exact(3 * N).zip(desired.chunks_exact(3 * N));
        let reward = |(a, d)| RewardKind::Sparse.of_goals(self.spec(), read(a), read(d));
        rows.map(|row| reward(row) >= 0.0).collect()
    }

    fn picture(&mut self, row: usize, painter: &mut Painter) -> Result<Option<Image>, EnvError> {
        let Frames { achieved, desired, .. } = Self::now(self);
        let goal = 3 * N * row..3 * N * (row + 1);
        let (achieved, desired) = (read(&achieved[goal.clone()]), read(&desired[goal]));
        let Some(env) = self.env_mut(row) else { return Ok(None) };
        painter.draw(env, achieved, &Desired::of_task(desired)).map(Some)
    }
}

/// What a pool is made of.
#[derive(Clone, Copy)]
pub(crate) struct Size {
    pub(crate) envs: usize,
    pub(crate) threads: usize,
    pub(crate) auto_reset: AutoReset,
    pub(crate) rewards: RewardKind,
    /// Those of the task if it is None.
    pub(crate) episode_steps: Option<NonZeroUsize>,
}

/// Makes a pool of environments of `task`.
pub(crate) fn build(
    task: Task,
    options: &Options,
    size: Size,
) -> Result<Result<Box<dyn AnyPool>, PoolError>, OptionError> {
    task.visit_with(options, size)
}

impl EnvVisitor for Size {
    type Output = Result<Box<dyn AnyPool>, PoolError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let envs: Vec<E> = (0..self.envs).map(|_| build()).collect();
        let pool = Pool::new(envs, self.threads, self.auto_reset)?.with_rewards(self.rewards);
        Ok(match self.episode_steps {
            Some(steps) => Box::new(pool.with_episode_steps(steps)),
            None => Box::new(pool),
        })
    }
}
