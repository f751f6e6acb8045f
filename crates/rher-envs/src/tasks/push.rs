//! FetchPush: push a block to a place on the table, with closed fingers.

use super::blocks::{Blocks, ON_TABLE, are_clear_of, draw_places};
use crate::layout::Layout;
use crate::observation::{Sink, gripper_and_object};
use crate::sim::{Fingers, World};
use crate::simulation::Scenario;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// How far from the gripper block and target are drawn, along x and y, in meters.
const SPREAD: f32 = 0.15;

/// Push a block to a place on the table.
///
/// Observation, action, goals and initial poses are those of `FetchPush-v4` (Gymnasium-Robotics
/// 1.4.2, `MuJoCo` 3.11.0); the fourth number of an action does nothing.
pub struct Push(Blocks<1>);

impl Scenario<1> for Push {
    const NAME: &'static str = "push";
    const VERBS: [&'static str; 1] = ["push"];
    const FRONT_LIKE_BACK: bool = true;

    fn build() -> (Self, World) {
        let (blocks, world) = Blocks::build(Fingers::Locked, ON_TABLE);
        (Self(blocks), world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        Layout::new(
            draw_places(ON_TABLE, SPREAD, rng, |places| are_clear_of(ON_TABLE, places)),
            draw_places(ON_TABLE, SPREAD, rng, |_| true),
        )
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
