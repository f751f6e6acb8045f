//! Episodes that were played, as pictures.

use super::caption::Captions;
use super::options::{Look, PictureSize};
use super::solved::solved;
use rher_core::config::TestPolicy;
use rher_core::env::{End, Env, EnvError, EnvSpec, Start};
use rher_core::episode::rollout;
use rher_core::evaluate::{Played, play};
use rher_core::goal::{Achieved, Desired};
use rher_core::policy::Policy;
use rher_core::seed::Seed;
use rher_envs::render::{Camera, Image, Renderer, Viewpoint, scene};
use rher_envs::thing::Thing;
use rher_envs::{EnvVisitor, Simulated, Task};

/// Films episodes in an environment of its own.
pub(crate) struct Filmer<E, const N: usize> {
    env: E,
    captions: Captions<N>,
    viewpoint: Viewpoint,
    renderer: Renderer,
}

/// An episode in pictures.
pub(crate) struct Footage {
    /// `[T + 1]`: of its beginning and of the end of each of its steps.
    pub(crate) images: Vec<Image>,
    /// Whether the task was solved in each of them.
    pub(crate) solved: Vec<bool>,
}

impl<E: Simulated<N>, const N: usize> Filmer<E, N> {
    /// Films in `env`, which is of `task`; `reach_distance` is the policy's, in meters.
    pub(crate) fn new(env: E, task: Task, reach_distance: f32, look: Look) -> Self {
        let captions = Captions::new(env.spec(), task, reach_distance);
        let Look { viewpoint, size: PictureSize(size) } = look;
        Self { env, captions, viewpoint, renderer: Renderer::new(size) }
    }

    /// Plays an episode again, and draws it.
    pub(crate) fn film(&mut self, played: &Played<N>) -> anyhow::Result<Footage> {
        let width = self.env.spec().action_dim;
        let solved = solved(played, &self.env.spec().tolerances);
        let viewpoint = self.viewpoint;
        let mut set = Set { env: &mut self.env, viewpoint, scenery: None, scenes: Vec::new() };
        let mut chosen = played.episode.actions.chunks_exact(width);
        rollout(&mut set, played.seed, |_, action| {
            action.copy_from_slice(chosen.next().unwrap_or_default());
            Ok(())
        })?;
        let Set { scenery, scenes, .. } = set;
        let mut images = Vec::with_capacity(scenes.len());
        if let Some((camera, _)) = scenery {
            for (step, things) in scenes.iter().enumerate() {
                let mut image = self.renderer.draw(&camera, things);
                self.captions.write(played, step, solved[step], &mut image);
                images.push(image);
            }
        }
        Ok(Footage { images, solved })
    }
}

/// An environment and what there was to see in it.
struct Set<'a, E, const N: usize> {
    env: &'a mut E,
    viewpoint: Viewpoint,
    /// The camera and the goals of the episode that has begun.
    scenery: Option<(Camera, Desired<N>)>,
    scenes: Vec<Vec<Thing>>,
}

impl<E: Simulated<N>, const N: usize> Set<'_, E, N> {
    fn look(&mut self, now: &Achieved<N>) {
        if let Some((_, desired)) = &self.scenery {
            self.scenes.push(scene(self.env, now, desired));
        }
    }
}

impl<const N: usize, E: Simulated<N>> Env<N> for Set<'_, E, N> {
    fn spec(&self) -> &EnvSpec<N> {
        self.env.spec()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        let start = self.env.reset(seed, observation)?;
        self.scenery = Some((self.viewpoint.camera(self.env, &start)?, start.desired));
        self.look(&start.achieved);
        Ok(start)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let achieved = self.env.step(action, observation)?;
        self.look(&achieved);
        Ok(achieved)
    }

    fn end(&self) -> Option<End> {
        self.env.end()
    }
}

/// Films the first evaluation episode of a task that is known at run time; there are no pictures
/// of an environment that names nothing that can be seen.
pub(crate) struct Film<'a> {
    pub(crate) task: Task,
    pub(crate) policy: &'a Policy,
    pub(crate) test_policy: TestPolicy,
}

impl EnvVisitor for Film<'_> {
    type Output = anyhow::Result<Footage>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { task, policy, test_policy } = self;
        let stage = policy.info().last_stage::<N>()?;
        let played = play(&mut build(), policy, stage, test_policy, Seed(0), 0)?;
        let env = build();
        if env.things().is_empty() {
            return Ok(Footage { images: Vec::new(), solved: Vec::new() });
        }
        let look = Look { viewpoint: Viewpoint::default(), size: PictureSize::DEFAULT };
        Filmer::new(env, task, policy.info().reach_distance, look).film(&played)
    }
}
