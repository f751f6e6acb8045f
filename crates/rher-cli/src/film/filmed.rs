//! Environments whose steps are filmed.

use rher_core::config::{EvaluationConfig, TestPolicy};
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::evaluate::evaluate;
use rher_core::goal::Achieved;
use rher_core::policy::Policy;
use rher_envs::render::{Camera, Image, Renderer};
use rher_envs::thing::Thing;
use rher_envs::{EnvVisitor, Simulated};
use std::num::NonZeroU16;

/// Width and height of moving pictures, in pixels.
pub(crate) const SIZE: [NonZeroU16; 2] = [pixels(400), pixels(300)];

const fn pixels(count: u16) -> NonZeroU16 {
    NonZeroU16::new(count).expect("pictures have pixels")
}

/// An environment that is filmed.
pub(crate) struct Filmed<E> {
    env: E,
    camera: Camera,
    renderer: Renderer,
    /// Marks of the goals of this episode.
    goals: Vec<Thing>,
    /// A picture of the beginning of every episode and of the end of each of its steps.
    episodes: Vec<Vec<Image>>,
}

impl<E> Filmed<E> {
    /// Films `env` in pictures of this width and height, in pixels.
    pub(crate) fn new<const N: usize>(env: E, size: [NonZeroU16; 2]) -> Self
    where
        E: Simulated<N>,
    {
        let camera = Camera::above_table(&env.things());
        let renderer = Renderer::new(size);
        Self { env, camera, renderer, goals: Vec::new(), episodes: Vec::new() }
    }

    /// The pictures of the episodes since the last time.
    pub(crate) fn take(&mut self) -> Vec<Vec<Image>> {
        std::mem::take(&mut self.episodes)
    }

    fn shoot<const N: usize>(&mut self)
    where
        E: Simulated<N>,
    {
        let mut things = self.env.things();
        things.extend_from_slice(&self.goals);
        let image = self.renderer.draw(&self.camera, &things);
        if let Some(episode) = self.episodes.last_mut() {
            episode.push(image);
        }
    }
}

impl<const N: usize, E: Simulated<N>> Env<N> for Filmed<E> {
    fn spec(&self) -> &EnvSpec<N> {
        self.env.spec()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        let start = self.env.reset(seed, observation)?;
        self.goals = self.env.goals(&start.desired);
        self.episodes.push(Vec::new());
        self.shoot();
        Ok(start)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let achieved = self.env.step(action, observation)?;
        self.shoot();
        Ok(achieved)
    }

    fn truth(&mut self) -> Option<Achieved<N>> {
        self.env.truth()
    }
}

/// Films the first evaluation episodes of a task that is known at run time.
pub(crate) struct Film<'a> {
    pub(crate) policy: &'a Policy,
    pub(crate) test_policy: TestPolicy,
    pub(crate) episodes: usize,
    pub(crate) size: [NonZeroU16; 2],
}

impl EnvVisitor for Film<'_> {
    type Output = anyhow::Result<Vec<Vec<Image>>>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { policy, test_policy, episodes, size } = self;
        let mut env = [Filmed::new(build(), size)];
        let config =
            EvaluationConfig { every_episodes: 1, episodes, subtask_episodes: 0, env_seed: 0 };
        evaluate(&mut env, policy, &config, test_policy)?;
        let [mut env] = env;
        Ok(env.take())
    }
}
