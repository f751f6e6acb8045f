//! FetchPush: push a block to a place on the table, with closed fingers.

use super::draw_block_and_target;
use crate::observation::{Sink, gripper_and_object};
use crate::sim::{Body, Fingers, World};
use crate::simulation::{Layout, MIDDLE, Scenario};
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Where the gripper starts, its fingers pressed on the table.
const HOME: Position = Position::new(1.363, MIDDLE, 0.416);

/// Push a block to a place on the table.
///
/// Observation, action, goals and initial poses are those of `FetchPush-v4` (Gymnasium-Robotics
/// 1.4.2, `MuJoCo` 3.11.0); the fourth number of an action does nothing.
pub struct Push {
    block: Body,
}

impl Scenario<1> for Push {
    const NAME: &'static str = "push";

    fn build() -> (Self, World) {
        let (world, block) = World::new(Fingers::Locked, HOME, |scenery| {
            scenery.table();
            scenery.block()
        });
        (Self { block }, world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        draw_block_and_target(HOME, rng)
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
