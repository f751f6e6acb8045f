//! The smallest environment with an object.

use crate::env::{Env, EnvError, EnvSpec, Start};
use crate::goal::{Achieved, Desired, Position, Scene};
use crate::seed::{Purpose, Seed};
use rand::RngExt as _;

/// A hand on a line, 1 m long, that carries a block while it is at the block and grips: the smallest
/// environment in which there is something to learn.
///
/// An observation is the hand's place and the block's, in meters; an action is the hand's motion, by
/// at most 10 cm, and whether it grips (above 0).
///
/// ```
/// use rher_core::testing::{Carry, check_env};
///
/// assert!(check_env(Carry::new).is_ok());
/// ```
#[derive(Clone, Debug)]
pub struct Carry {
    spec: EnvSpec<1>,
    scene: Scene<1>,
}

impl Carry {
    /// The environment, before its first episode.
    pub fn new() -> Self {
        let origin = Position::origin();
        Self { spec: EnvSpec::new("carry", 2, 2, 20), scene: Scene::new(origin, [origin]) }
    }

    fn observe(&self, observation: &mut [f32]) -> Achieved<1> {
        observation.copy_from_slice(&[self.scene.gripper.x, self.scene.objects[0].x]);
        Achieved(self.scene)
    }
}

impl Default for Carry {
    fn default() -> Self {
        Self::new()
    }
}

impl Env<1> for Carry {
    fn spec(&self) -> &EnvSpec<1> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
        let mut rng = Seed(seed).stream(Purpose::Environment, 0);
        let mut place = || Position::new(rng.random(), 0.0, 0.0);
        self.scene = Scene::new(place(), [place()]);
        let desired = Desired::of_task([place()]);
        Ok(Start { achieved: self.observe(observation), desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
        let Scene { gripper: hand, objects: [block], .. } = &mut self.scene;
        let carries = action[1] > 0.0 && (hand.x - block.x).abs() < 0.05;
        hand.x = (hand.x + 0.1 * action[0]).clamp(0.0, 1.0);
        if carries {
            *block = *hand;
        }
        Ok(self.observe(observation))
    }
}
