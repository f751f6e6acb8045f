//! `TPush`: push three blocks, each to its place on the table, with closed fingers.

use super::blocks::{Blocks, ON_TABLE, are_apart, are_clear_of, draw_places, overlap};
use crate::layout::Layout;
use crate::observation::{Sink, gripper_and_three_objects};
use crate::sim::{Fingers, World};
use crate::simulation::Scenario;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// How far from the gripper blocks and targets are drawn, along x and y, in meters.
const SPREAD: f32 = 0.1;

/// Meters between the targets.
const TARGETS_APART: f32 = 0.1;

/// Push three blocks, each to its place on the table.
///
/// The paper's `TPush`, with the ranges and the observation of the authors' `FetchThreePush`; the
/// fourth number of an action does nothing. Blocks start beside one another: the authors' rule,
/// 5 cm from center to center, lets their corners overlap.
pub struct TPush(Blocks<3>);

impl Scenario<3> for TPush {
    const NAME: &'static str = "tpush";
    const VERBS: [&'static str; 3] = ["push"; 3];
    const FRONT_LIKE_BACK: bool = true;
    const EPISODE_STEPS: usize = 70;
    const ALIKE: bool = true;
    const ANY_ORDER: bool = true;

    fn build() -> (Self, World) {
        let (blocks, world) = Blocks::build(Fingers::Locked, ON_TABLE);
        (Self(blocks), world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<3> {
        Layout::new(
            draw_places(ON_TABLE, SPREAD, rng, |places| {
                are_clear_of(ON_TABLE, places) && !overlap(places)
            }),
            draw_places(ON_TABLE, SPREAD, rng, |places| are_apart(TARGETS_APART, places)),
        )
    }

    fn place(&self, layout: &Layout<3>, world: &mut World) {
        self.0.place(layout, world);
    }

    fn objects(&self, _: &Layout<3>, world: &World) -> [Position; 3] {
        self.0.positions(world)
    }

    fn observe(&self, _: &Layout<3>, world: &World, out: &mut impl Sink) {
        gripper_and_three_objects(&world.grip(), &self.0.motions(world), out);
    }
}
