//! A cabinet with a drawer that is pulled by its handle.

use super::body::{Body, Motion};
use super::edges::rounded;
use super::look::{DRAWER as PAINT, FURNITURE};
use super::material::with_friction;
use super::scenery::Scenery;
use super::world::World;
use crate::thing::object_color;
use nalgebra::Vector3;
use rapier3d::prelude::{
    ColliderBuilder, GenericJointBuilder, JointAxesMask, JointAxis, LockedAxes, MotorModel,
    RigidBodyBuilder, Vector,
};
use rher_core::goal::Position;

/// How far the drawer opens, in meters.
pub(crate) const DRAWER_TRAVEL: f32 = 0.2;

/// Height of the drawer's bottom, on which things lie, above the cabinet's foot, in meters.
const BOTTOM: f32 = 0.075;

/// From the middle of the cabinet's foot to the middle of the handle's bow, in meters.
const HANDLE: Vector3<f32> = Vector3::new(-0.124, 0.0, 0.13);

/// Kilograms.
const DRAWER_MASS: f32 = 2.0;

/// Dry friction of the drawer's slide, in newtons.
const FRICTION: f32 = 30.0;

/// Newton seconds per meter: the drawer creeps by a millimeter per second for every newton that
/// pulls it, up to its friction.
const CREEP: f32 = 1000.0;

/// The sides, the top and the back of the cabinet: centers from its foot and half edges, in meters.
const CASE: [(Vector, Vector); 4] = [
    (Vector::new(0.0, -0.105, 0.084), Vector::new(0.1, 0.005, 0.084)),
    (Vector::new(0.0, 0.105, 0.084), Vector::new(0.1, 0.005, 0.084)),
    (Vector::new(0.0, 0.0, 0.163), Vector::new(0.1, 0.1, 0.005)),
    (Vector::new(0.095, 0.0, 0.079), Vector::new(0.005, 0.1, 0.079)),
];

/// Bottom, front, back and sides of the closed drawer, then the bar of its handle and what holds
/// it: centers from the cabinet's foot and half edges, in meters.
const DRAWER: [(Vector, Vector); 8] = [
    (Vector::new(-0.0085, 0.0, BOTTOM - 0.005), Vector::new(0.0915, 0.095, 0.005)),
    (Vector::new(-0.095, 0.0, 0.08), Vector::new(0.005, 0.095, 0.07)),
    (Vector::new(0.078, 0.0, 0.1), Vector::new(0.005, 0.095, 0.035)),
    (Vector::new(-0.0085, -0.09, 0.1), Vector::new(0.0915, 0.005, 0.035)),
    (Vector::new(-0.0085, 0.09, 0.1), Vector::new(0.0915, 0.005, 0.035)),
    (Vector::new(-0.152, 0.0, 0.125), Vector::new(0.006, 0.056, 0.01)),
    (Vector::new(-0.126, -0.05, 0.125), Vector::new(0.026, 0.006, 0.01)),
    (Vector::new(-0.126, 0.05, 0.125), Vector::new(0.026, 0.006, 0.01)),
];

/// A cabinet that stands open towards −x, and its drawer.
#[derive(Clone, Copy)]
pub(crate) struct Cabinet {
    case: Body,
    drawer: Body,
}

impl Scenery {
    /// A cabinet of 20 by 22 cm, 16.8 cm high, with one drawer.
    pub(crate) fn cabinet(&mut self) -> Cabinet {
        let case = self.bodies.insert(RigidBodyBuilder::fixed());
        // Locked axes: a joint that held them would be bent by the gripper.
        let drawer = RigidBodyBuilder::dynamic()
            .locked_axes(
                LockedAxes::ROTATION_LOCKED
                    | LockedAxes::TRANSLATION_LOCKED_Y
                    | LockedAxes::TRANSLATION_LOCKED_Z,
            )
            .can_sleep(false);
        let drawer = self.bodies.insert(drawer);
        for (body, boxes, mass) in [
            (case, CASE.as_slice(), 0.0),
            (drawer, DRAWER.as_slice(), DRAWER_MASS / DRAWER.len() as f32),
        ] {
            for (center, half) in boxes {
                let wall = with_friction(ColliderBuilder::cuboid(half.x, half.y, half.z));
                let wall = rounded(wall).translation(*center).mass(mass);
                self.colliders.insert_with_parent(wall, body, &mut self.bodies);
            }
        }
        let slide = GenericJointBuilder::new(JointAxesMask::empty())
            .limits(JointAxis::LinX, [-DRAWER_TRAVEL, 0.0])
            .motor_model(JointAxis::LinX, MotorModel::ForceBased)
            .motor_velocity(JointAxis::LinX, 0.0, CREEP)
            .motor_max_force(JointAxis::LinX, FRICTION)
            .contacts_enabled(false);
        self.joints.insert(case, drawer, slide, true);
        self.show("cabinet", Body(case), &[FURNITURE]);
        // The handle is the object.
        self.show("drawer", Body(drawer), &[PAINT, PAINT, PAINT, PAINT, PAINT, object_color(0)]);
        Cabinet { case: Body(case), drawer: Body(drawer) }
    }
}

impl Cabinet {
    /// Puts the cabinet of a fresh world where its closed drawer has its handle at `handle`, and
    /// opens the drawer by meters.
    pub(crate) fn place(self, handle: Position, open: f32, world: &mut World) {
        let foot = handle - HANDLE;
        world.place(self.case, foot, 0.0);
        world.place(self.drawer, foot - Vector3::x() * open, 0.0);
    }

    /// The middle of the handle's bow.
    pub(crate) fn handle(self, world: &World) -> Motion {
        let drawer = world.motion(self.drawer);
        Motion { position: drawer.position + HANDLE, ..drawer }
    }
}
