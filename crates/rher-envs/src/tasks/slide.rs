//! `FetchSlide`: hit a puck so that it slides to a place beyond reach.

use crate::layout::Layout;
use crate::observation::{Sink, gripper_and_object};
use crate::sim::{Body, Fingers, PUCK_HEIGHT, World};
use crate::simulation::{MIDDLE, Scenario};
use nalgebra::Vector3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Where the gripper starts, its fingers pressed on the table.
const HOME: Position = Position::new(1.0131, MIDDLE, 0.4155);

/// The robot stands further back than in `FetchPush`, in meters.
const FURTHER_BACK: Vector3<f32> = Vector3::new(-0.3549, 0.0, 0.0);

/// Height of the puck's center on the table, in meters.
const PUCK_CENTER: f32 = 0.4 + PUCK_HEIGHT / 2.0;

/// How far from the gripper the puck is drawn, along x and y, in meters.
const PUCK_SPREAD: f32 = 0.1;

/// How near to the gripper the puck never starts, along the table, in meters.
const CLEARANCE: f32 = 0.1;

/// How far ahead of the gripper the middle of the targets is, in meters.
const AHEAD: f32 = 0.4;

/// How far from their middle targets are drawn, along x and y, in meters.
const TARGET_SPREAD: f32 = 0.3;

/// Hit a puck so that it slides to a place beyond reach.
///
/// Observation, action, goals and initial poses are those of `FetchSlide-v4` (Gymnasium-Robotics
/// 1.4.2, `MuJoCo` 3.11.0); the fourth number of an action does nothing.
pub struct Slide {
    puck: Body,
}

impl Scenario<1> for Slide {
    const NAME: &'static str = "slide";
    const VERBS: [&'static str; 1] = ["slide"];
    const OBJECTS: [&'static str; 1] = ["puck"];
    const RECIPE: Option<&'static str> = Some(include_str!("slide.toml"));

    fn build() -> (Self, World) {
        let (world, puck) = World::new(Fingers::Locked, HOME, |scenery| {
            scenery.move_robot(FURTHER_BACK);
            scenery.slide_table();
            scenery.puck()
        });
        (Self { puck }, world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        let mut draw = |ahead: f32, spread: f32| {
            let mut offset = || rng.random_range(-spread..spread);
            Position::new(HOME.x + ahead + offset(), HOME.y + offset(), PUCK_CENTER)
        };
        let puck = loop {
            let puck = draw(0.0, PUCK_SPREAD);
            if (puck - HOME).xy().norm() >= CLEARANCE {
                break puck;
            }
        };
        Layout::new([puck], [draw(AHEAD, TARGET_SPREAD)])
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        world.place(self.puck, layout.objects[0], layout.turns[0]);
    }

    fn objects(&self, _: &Layout<1>, world: &World) -> [Position; 1] {
        [world.motion(self.puck).position]
    }

    fn observe(&self, _: &Layout<1>, world: &World, out: &mut impl Sink) {
        gripper_and_object(&world.grip(), &world.motion(self.puck), out);
    }
}
