//! Stack: bring a block to a place on the table, and another on top of it.

use super::blocks::{Blocks, IN_THE_AIR, are_apart, are_clear_of, draw_places, stacked_on};
use crate::layout::Layout;
use crate::observation::{Sink, gripper_and_two_objects};
use crate::sim::{Fingers, World};
use crate::simulation::Scenario;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// How far from the gripper blocks and targets are drawn, along x and y, in meters.
const SPREAD: f32 = 0.1;

/// Meters between the blocks at the start.
const BLOCKS_APART: f32 = 0.08;

/// Bring a block to a place on the table, and another on top of it.
///
/// The paper's Stack, with the ranges and the observation of the authors' `FetchStack`.
pub struct Stack(Blocks<2>);

impl Scenario<2> for Stack {
    const NAME: &'static str = "stack";
    const FRONT_LIKE_BACK: bool = true;
    const EPISODE_STEPS: usize = 60;
    const ALIKE: bool = true;

    fn build() -> (Self, World) {
        let (blocks, world) = Blocks::build(Fingers::Free, IN_THE_AIR);
        (Self(blocks), world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<2> {
        let objects = draw_places(IN_THE_AIR, SPREAD, rng, |places| {
            are_clear_of(IN_THE_AIR, places) && are_apart(BLOCKS_APART, places)
        });
        let [foot] = draw_places(IN_THE_AIR, SPREAD, rng, |_| true);
        Layout::new(objects, stacked_on(foot))
    }

    fn place(&self, layout: &Layout<2>, world: &mut World) {
        self.0.place(layout, world);
    }

    fn objects(&self, _: &Layout<2>, world: &World) -> [Position; 2] {
        self.0.positions(world)
    }

    fn observe(&self, _: &Layout<2>, world: &World, out: &mut impl Sink) {
        gripper_and_two_objects(&world.grip(), &self.0.motions(world), out);
    }
}
