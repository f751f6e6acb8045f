//! Worlds without physics: a point that moves, and objects that stick to it.

#![cfg_attr(not(feature = "train"), expect(dead_code, reason = "only training needs all of it"))]

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::config::{Preset, TrainConfig};
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::event::{Event, Metrics, Observer, ObserverError};
use rher_core::goal::{Achieved, Desired, Position, Scene, Tolerances};
use rher_core::{Control, Names};

/// How far an action moves the gripper, in meters.
const STRIDE: f32 = 0.1;
/// How near the gripper must be for an object to stick to it.
const GRASP: f32 = 0.1;

/// A gripper in a flat unit square; an object that it touches while its third action is positive
/// jumps to it and goes with it.
pub(crate) struct Magnet<const N: usize> {
    spec: EnvSpec<N>,
    scene: Scene<N>,
    desired: [Position; N],
}

impl<const N: usize> Magnet<N> {
    pub(crate) fn new() -> Self {
        let origin = Position::origin();
        Self {
            spec: EnvSpec {
                name: "magnet".to_owned(),
                variant: String::new(),
                obs_dim: 2 * (N + 1),
                action_dim: 3,
                episode_steps: 25,
                subtasks: 2 * N,
                tolerances: Tolerances::uniform(0.07),
                mirrors: Vec::new(),
                permutations: Vec::new(),
                any_order: false,
                names: Names::default(),
                control: Control::default(),
            },
            scene: Scene::new(origin, [origin; N]),
            desired: [origin; N],
        }
    }

    fn observe(&self, observation: &mut [f32]) {
        let places = std::iter::once(&self.scene.gripper).chain(&self.scene.objects);
        for (out, place) in observation.chunks_exact_mut(2).zip(places) {
            out.copy_from_slice(&[place.x, place.y]);
        }
    }
}

impl<const N: usize> Env<N> for Magnet<N> {
    fn spec(&self) -> &EnvSpec<N> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut place = || Position::new(rng.random(), rng.random(), 0.0);
        self.scene = Scene::new(Position::new(0.5, 0.5, 0.0), [(); N].map(|()| place()));
        self.desired = [(); N].map(|()| place());
        self.observe(observation);
        Ok(Start { achieved: Achieved(self.scene), desired: Desired::of_task(self.desired) })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let before = self.scene.gripper;
        let step = |place: f32, action: f32| (place + STRIDE * action).clamp(0.0, 1.0);
        self.scene.gripper =
            Position::new(step(before.x, action[0]), step(before.y, action[1]), 0.0);
        let near = |object: &&mut Position| nalgebra::distance(&**object, &before) < GRASP;
        if let Some(object) = self.scene.objects.iter_mut().find(near)
            && action[2] > 0.0
        {
            *object = self.scene.gripper;
        }
        self.observe(observation);
        Ok(Achieved(self.scene))
    }
}

/// Settings that train in seconds.
pub(crate) fn small(task: &str, objects: usize) -> TrainConfig {
    let mut config = Preset::Fast.config(task, objects);
    config.agent.hidden = vec![32, 32];
    config.agent.critics = 1;
    config.agent.policy_delay = 1;
    config.agent.target_noise = 0.0;
    config.replay.updates_per_episode = 40;
    config.replay.batch_size = 64;
    config.replay.warmup_episodes = 0;
    config.evaluation.every_episodes = 10;
    config.evaluation.episodes = 50;
    config.evaluation.subtask_episodes = 20;
    config.until = 0.0;
    config
}

/// Keeps every line of metrics.
#[derive(Default)]
pub(crate) struct Lines(pub(crate) Vec<Metrics>);

impl Observer for Lines {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        if let Event::Evaluated(metrics) = event {
            self.0.push((**metrics).clone());
        }
        Ok(())
    }
}
