//! `DPush`: push two blocks, each to its place on the table, with closed fingers.

use super::blocks::{Blocks, ON_TABLE, are_apart, are_clear_of, draw_places};
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

/// Meters between the targets.
const TARGETS_APART: f32 = 0.1;

/// Push two blocks, each to its place on the table.
///
/// The paper's `DPush`, with the ranges and the observation of the authors' `FetchDoublePush`; the
/// fourth number of an action does nothing.
pub struct DPush(Blocks<2>);

impl Scenario<2> for DPush {
    const NAME: &'static str = "dpush";
    const VERBS: [&'static str; 2] = ["push"; 2];
    const FRONT_LIKE_BACK: bool = true;
    const EPISODE_STEPS: usize = 60;
    const ALIKE: bool = true;
    const ANY_ORDER: bool = true;

    fn build() -> (Self, World) {
        let (blocks, world) = Blocks::build(Fingers::Locked, ON_TABLE);
        (Self(blocks), world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<2> {
        Layout::new(
            draw_places(ON_TABLE, SPREAD, rng, |places| {
                are_clear_of(ON_TABLE, places) && are_apart(BLOCKS_APART, places)
            }),
            draw_places(ON_TABLE, SPREAD, rng, |places| are_apart(TARGETS_APART, places)),
        )
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
