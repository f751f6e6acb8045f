//! FetchPickAndPlace: bring a block to a place on the table or above it.

use super::blocks::{Blocks, IN_THE_AIR, are_clear_of, draw_places};
use crate::layout::Layout;
use crate::observation::{Sink, gripper_and_object};
use crate::sim::{Fingers, World};
use crate::simulation::Scenario;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// How far from the gripper block and target are drawn, along x and y, in meters.
const SPREAD: f32 = 0.15;

/// Of all targets, those that are above the table.
const LIFTED: f64 = 0.5;

/// How far above the table a target is at most, in meters.
const LIFT: f32 = 0.45;

/// Bring a block to a place on the table or above it.
///
/// Observation, action, goals and initial poses are those of `FetchPickAndPlace-v4`
/// (Gymnasium-Robotics 1.4.2, `MuJoCo` 3.11.0).
pub struct Pick(Blocks<1>);

impl Scenario<1> for Pick {
    const NAME: &'static str = "pick";
    const FRONT_LIKE_BACK: bool = true;

    fn build() -> (Self, World) {
        let (blocks, world) = Blocks::build(Fingers::Free, IN_THE_AIR);
        (Self(blocks), world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        let mut layout = Layout::new(
            draw_places(IN_THE_AIR, SPREAD, rng, |places| are_clear_of(IN_THE_AIR, places)),
            draw_places(IN_THE_AIR, SPREAD, rng, |_| true),
        );
        if rng.random_bool(LIFTED) {
            layout.targets[0].z += rng.random_range(0.0..LIFT);
        }
        layout
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        self.0.place(layout, world);
    }

    fn objects(&self, _: &Layout<1>, world: &World) -> [Position; 1] {
        self.0.positions(world)
    }

    fn observe(&self, _: &Layout<1>, world: &World, out: &mut impl Sink) {
        let [block] = self.0.motions(world);
        gripper_and_object(&world.grip(), &block, out);
    }
}
