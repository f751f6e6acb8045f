//! Drawer: pull a drawer open by its handle.

use crate::layout::Layout;
use crate::observation::{Sink, gripper_and_object};
use crate::sim::{Cabinet, Fingers, World};
use crate::simulation::{MIDDLE, Scenario};
use nalgebra::Vector3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Where the gripper starts.
const HOME: Position = Position::new(1.3419, MIDDLE, 0.6347);

/// Where the robot stands, from where it stands in `FetchPush`.
const HIGHER: Vector3<f32> = Vector3::new(0.0, 0.0, 0.15);

/// Where the handle of the closed drawer is.
const HANDLE: Position = Position::new(1.376, 0.63, 0.45);

/// How far an action of 1 moves the point that the hand is after, in meters.
const REACH_PER_STEP: f32 = 0.04;

/// Pull a drawer open by its handle.
///
/// The paper's Drawer, with the ranges, the tolerance and the observation of the authors'
/// `FetchDrawer`; the object is the middle of the handle's bow, where fingers reach in, and the
/// fourth number of an action does nothing.
pub struct Drawer(Cabinet);

impl Scenario<1> for Drawer {
    const NAME: &'static str = "drawer";
    const VERBS: [&'static str; 1] = ["open"];
    const OBJECTS: [&'static str; 1] = ["handle"];
    const TOLERANCE: f32 = 0.02;

    fn build() -> (Self, World) {
        let (world, cabinet) = World::new(Fingers::Locked, HOME, |scenery| {
            scenery.move_robot(HIGHER);
            scenery.slow_hand(REACH_PER_STEP);
            scenery.keep_hand_above(HANDLE.z);
            scenery.cabinet_table();
            scenery.cabinet()
        });
        (Self(cabinet), world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        let open = 0.04 + rng.random_range(0.0..0.16);
        Layout::new([HANDLE], [HANDLE - Vector3::x() * open])
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        let [handle] = layout.objects;
        self.0.place(Position::new(HANDLE.x, handle.y, HANDLE.z), HANDLE.x - handle.x, world);
    }

    fn objects(&self, _: &Layout<1>, world: &World) -> [Position; 1] {
        [self.0.handle(world).position]
    }

    fn observe(&self, _: &Layout<1>, world: &World, out: &mut impl Sink) {
        gripper_and_object(&world.grip(), &self.0.handle(world), out);
    }
}
