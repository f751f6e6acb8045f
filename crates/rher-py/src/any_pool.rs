//! Environments of one task that are stepped together, the task being known at run time only.

use crate::any_env::read;
use rher_core::env::Env;
use rher_envs::{
    AutoReset, EnvVisitor, Frames, OptionError, Options, Pool, PoolError, Simulated, Task,
    reward_of_goals,
};

/// A [`Pool`], whatever its task.
pub(crate) trait AnyPool: Send {
    fn reset(&mut self, seeds: &[u64]) -> Result<(), PoolError>;

    fn reset_where(&mut self, mask: &[bool]) -> Result<(), PoolError>;

    fn step(&mut self, actions: &[f32]) -> Result<(), PoolError>;

    fn now(&self) -> &Frames;

    fn last(&self) -> &Frames;

    fn rewards(&self) -> &[f32];

    fn successes(&self) -> &[bool];

    fn ended(&self) -> &[bool];

    /// Whether what is seen now solves the task, row by row.
    fn solved(&self) -> Vec<bool>;
}

impl<E: Env<N>, const N: usize> AnyPool for Pool<E, N> {
    fn reset(&mut self, seeds: &[u64]) -> Result<(), PoolError> {
        Self::reset(self, seeds)
    }

    fn reset_where(&mut self, mask: &[bool]) -> Result<(), PoolError> {
        Self::reset_where(self, mask)
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

    fn solved(&self) -> Vec<bool> {
        let Frames { achieved, desired, .. } = Self::now(self);
        let rows = achieved.chunks_exact(3 * N).zip(desired.chunks_exact(3 * N));
        rows.map(|(a, d)| reward_of_goals(self.spec(), read(a), read(d)) >= 0.0).collect()
    }
}

/// Makes `envs` environments of `task`, stepped by as many `threads`.
pub(crate) fn build(
    task: Task,
    options: &Options,
    envs: usize,
    threads: usize,
    auto_reset: AutoReset,
) -> Result<Result<Box<dyn AnyPool>, PoolError>, OptionError> {
    task.visit_with(options, Build { envs, threads, auto_reset })
}

struct Build {
    envs: usize,
    threads: usize,
    auto_reset: AutoReset,
}

impl EnvVisitor for Build {
    type Output = Result<Box<dyn AnyPool>, PoolError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let envs: Vec<E> = (0..self.envs).map(|_| build()).collect();
        Ok(Box::new(Pool::new(envs, self.threads, self.auto_reset)?))
    }
}
