//! FetchReach: bring the gripper to a place in the air.

use crate::layout::Layout;
use crate::observation::{Sink, gripper_alone};
use crate::sim::{Fingers, Scenery, World};
use crate::simulation::{MIDDLE, Scenario};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Where the gripper starts, its fingers closed.
const HOME: Position = Position::new(1.3418, MIDDLE, 0.5347);

/// How far from the gripper targets are drawn, along each axis, in meters.
const SPREAD: f32 = 0.15;

/// Bring the gripper to a place in the air.
///
/// The place is an object that nothing moves and that is where it should be; there is only its
/// first sub-task, to reach it. Observation, action, goals and initial poses are those of
/// `FetchReach-v4` (Gymnasium-Robotics 1.4.2, `MuJoCo` 3.11.0).
pub struct Reach;

impl Scenario<1> for Reach {
    const NAME: &'static str = "reach";
    const OBJECTS: [&'static str; 1] = ["target"];
    const FRONT_LIKE_BACK: bool = true;
    const SUBTASKS: usize = 1;
    const RECIPE: Option<&'static str> = Some(include_str!("reach.toml"));

    fn build() -> (Self, World) {
        let (world, ()) = World::new(Fingers::Locked, HOME, Scenery::table);
        (Self, world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        let target = HOME.map(|home| home + rng.random_range(-SPREAD..SPREAD));
        Layout::new([target], [target])
    }

    fn place(&self, _: &Layout<1>, _: &mut World) {}

    fn objects(&self, layout: &Layout<1>, _: &World) -> [Position; 1] {
        layout.targets
    }

    fn observe(&self, _: &Layout<1>, world: &World, out: &mut impl Sink) {
        gripper_alone(&world.grip(), out);
    }
}
