//! Insert: bring the gripper into a hole.

use crate::layout::Layout;
use crate::observation::{Sink, tip_and_place};
use crate::sim::{Body, Fingers, PLATE_HEIGHT, World};
use crate::simulation::{MIDDLE, Scenario};
use nalgebra::Vector3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Where the grip center starts, above the plate.
const HOME: Position = Position::new(1.3419, MIDDLE, 0.5347);

/// From the grip center to the tip of the fingers.
const TIP: Vector3<f32> = Vector3::new(0.0, 0.0, -0.02);

/// Height of the table, in meters.
const TABLE: f32 = 0.36;

/// Height of the plate's rim, in meters.
const RIM: f32 = TABLE + PLATE_HEIGHT;

/// Where the tip should go, above the table, in meters.
const DEPTH: f32 = 0.01;

/// How near to the axis of the hole the tip is in it, in meters.
const ON_AXIS: f32 = 0.01;

/// How far above the target the tip is no longer in the hole, in meters.
const ABOVE: f32 = 0.09;

/// Bring the gripper into a hole.
///
/// The paper's Insert. There is nothing to move, so the object is the tip of the fingers for as
/// long as it is in the hole or close above it, and the middle of the hole's rim otherwise: to
/// reach it is to find the hole, to place it is to go in. Plate, ranges, tolerance and observation
/// are those of the authors' `FetchInsert`; wherever the gripper is told, it is its tip.
pub struct Insert {
    plate: Body,
}

impl Scenario<1> for Insert {
    const NAME: &'static str = "insert";
    const VERBS: [&'static str; 1] = ["insert"];
    const OBJECTS: [&'static str; 1] = ["hole"];
    const TOLERANCE: f32 = 0.01;

    fn build() -> (Self, World) {
        let (world, plate) = World::new(Fingers::Locked, HOME, |scenery| {
            scenery.low_table();
            scenery.plate_with_hole()
        });
        (Self { plate }, world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        let (x, y) = (rng.random_range(1.1..1.45), rng.random_range(0.5..0.85));
        Layout::new([Position::new(x, y, RIM)], [Position::new(x, y, TABLE + DEPTH)])
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        let [hole] = layout.targets;
        let center = Position::new(hole.x, hole.y, TABLE + PLATE_HEIGHT / 2.0);
        world.place(self.plate, center, 0.0);
    }

    fn gripper(&self, world: &World) -> Position {
        world.grip().position + TIP
    }

    fn objects(&self, layout: &Layout<1>, world: &World) -> [Position; 1] {
        let [hole] = layout.targets;
        let tip = self.gripper(world);
        let offset = tip - hole;
        let is_in = offset.xy().norm() < ON_AXIS && offset.z.abs() < ABOVE;
        [if is_in { tip } else { Position::new(hole.x, hole.y, RIM) }]
    }

    fn observe(&self, layout: &Layout<1>, world: &World, out: &mut impl Sink) {
        let [object] = self.objects(layout, world);
        tip_and_place(self.gripper(world), object, &world.grip(), out);
    }
}
