//! FetchPickAndPlace: bring a block to a place on the table or above it.

use super::draw_block_and_target;
use crate::observation::{Sink, gripper_and_object};
use crate::sim::{Body, Fingers, World};
use crate::simulation::{Layout, MIDDLE, Scenario};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Where the gripper starts, its fingers closed.
const HOME: Position = Position::new(1.3419, MIDDLE, 0.5347);

/// Of all targets, those that are above the table.
const IN_THE_AIR: f64 = 0.5;

/// How far above the table a target is at most, in metres.
const LIFT: f32 = 0.45;

/// Bring a block to a place on the table or above it.
///
/// Observation, action, goals and initial poses are those of `FetchPickAndPlace-v4`
/// (Gymnasium-Robotics 1.4.2, `MuJoCo` 3.11.0).
pub struct Pick {
    block: Body,
}

impl Scenario<1> for Pick {
    const NAME: &'static str = "pick";

    fn build() -> (Self, World) {
        let (world, block) = World::new(Fingers::Free, HOME, |scenery| {
            scenery.table();
            scenery.block()
        });
        (Self { block }, world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        let mut layout = draw_block_and_target(HOME, rng);
        if rng.random_bool(IN_THE_AIR) {
            layout.targets[0].z += rng.random_range(0.0..LIFT);
        }
        layout
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        world.place(self.block, layout.objects[0]);
    }

    fn objects(&self, _: &Layout<1>, world: &World) -> [Position; 1] {
        [world.motion(self.block).position]
    }

    fn observe(&self, _: &Layout<1>, world: &World, out: &mut impl Sink) {
        gripper_and_object(&world.grip(), &world.motion(self.block), out);
    }
}
