//! `TStack`: bring a block to a place on the table, and two more on top of it.

use super::blocks::{Blocks, IN_THE_AIR, are_apart, are_clear_of, draw_places, stacked_on};
use crate::layout::Layout;
use crate::observation::{Sink, gripper_and_stack};
use crate::sim::{Fingers, World};
use crate::simulation::Scenario;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// How far from the gripper blocks and targets are drawn, along x and y, in meters.
const SPREAD: f32 = 0.1;

/// Meters between the blocks at the start.
const BLOCKS_APART: f32 = 0.08;

/// Bring a block to a place on the table, and two more on top of it.
///
/// The paper's `TStack`, with the ranges and the observation of the authors' `FetchThreeStack`.
pub struct TStack(Blocks<3>);

impl Scenario<3> for TStack {
    const NAME: &'static str = "tstack";
    const FRONT_LIKE_BACK: bool = true;
    const EPISODE_STEPS: usize = 70;
    const ALIKE: bool = true;
    const RECIPE: Option<&'static str> = Some(include_str!("tstack.toml"));

    fn build() -> (Self, World) {
        let (blocks, world) = Blocks::build(Fingers::Free, IN_THE_AIR);
        (Self(blocks), world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<3> {
        let objects = draw_places(IN_THE_AIR, SPREAD, rng, |places| {
            are_clear_of(IN_THE_AIR, places) && are_apart(BLOCKS_APART, places)
        });
        let [foot] = draw_places(IN_THE_AIR, SPREAD, rng, |_| true);
        Layout::new(objects, stacked_on(foot))
    }

    fn place(&self, layout: &Layout<3>, world: &mut World) {
        self.0.place(layout, world);
    }

    fn objects(&self, _: &Layout<3>, world: &World) -> [Position; 3] {
        self.0.positions(world)
    }

    fn observe(&self, _: &Layout<3>, world: &World, out: &mut impl Sink) {
        gripper_and_stack(&world.grip(), &self.0.motions(world), out);
    }
}
