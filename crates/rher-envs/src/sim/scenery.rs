//! What stands around the gripper.

use super::body::{Body, Loose};
use super::convert::glam;
use super::edges::rounded;
use super::gripper::HandRange;
use super::look::{FURNITURE, Look, Solid, TABLE};
use super::material::{rough, slippery, with_friction};
use crate::thing::{Color, object_color};
use nalgebra::Vector3;
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, ColliderSet, ImpulseJointSet, RigidBodyBuilder,
    RigidBodyHandle, RigidBodySet, Vector,
};
use rher_core::goal::Position;
use std::f32::consts::FRAC_PI_2;

/// Edge of a block, in meters.
pub(crate) const BLOCK_EDGE: f32 = 0.05;

/// Kilograms.
const BLOCK_MASS: f32 = 2.0;

/// Kilograms.
const SLUGGISH_MASS: f32 = 4.0;

/// Kilogram square meters, about each axis.
const SLUGGISH_INERTIA: f32 = 0.01;

/// Newton seconds per meter, and newton meter seconds per radian.
const SLUGGISH_DAMPING: f32 = 10.0;

/// Meters.
const PUCK_RADIUS: f32 = 0.025;

/// Meters.
pub(crate) const PUCK_HEIGHT: f32 = 0.04;

/// Kilograms.
const PUCK_MASS: f32 = 2.0;

/// Meters.
pub(crate) const CYLINDER_RADIUS: f32 = 0.025;

/// Meters.
pub(crate) const CYLINDER_HEIGHT: f32 = 0.03;

/// Kilograms: beech.
const CYLINDER_MASS: f32 = 0.04;

/// Weight of the cylinder, as a multiple of what it is on Earth: the arm of a real robot is slow, and
/// what it does in 0.2 s is done in a step of 0.04 s here. With the square of 5 times the gravity the
/// cylinder neither glides nor tips where it would not there (equal Froude numbers).
const CYLINDER_GRAVITY: f32 = 25.0;

/// Coefficient of friction of planed wood on planed wood.
const WOOD_ON_WOOD: f32 = 0.4;

/// Half the edges of the obstacle, in meters.
pub(crate) const OBSTACLE_HALF: [f32; 3] = [0.01, 0.04, 0.025];

/// Coefficient of friction of the obstacle: with 1, a hand that presses on it is caught, which
/// `MuJoCo`'s soft contacts let slide along it.
const OBSTACLE_FRICTION: f32 = 0.1;

/// Meters.
pub(crate) const PLATE_HEIGHT: f32 = 0.08;

/// A [`World`](super::World) that is being furnished.
pub struct Scenery {
    pub(super) bodies: RigidBodySet,
    pub(super) colliders: ColliderSet,
    pub(super) joints: ImpulseJointSet,
    /// What can be moved freely.
    pub(super) loose: Vec<Loose>,
    /// What can be seen.
    pub(super) looks: Vec<Look>,
    /// From where the robot stands in `FetchPush` to where it stands here, in meters.
    pub(super) robot: Vector3<f32>,
    pub(super) hand_range: HandRange,
}

impl Scenery {
    /// The ground on which what leaves the table ends up.
    pub(super) fn floor(&mut self) {
        let floor = ColliderBuilder::cuboid(10.0, 10.0, 0.5);
        self.colliders.insert(with_friction(floor).translation(Vector::new(1.3, 0.75, -0.5)));
    }

    /// The table of every Fetch task but Slide: its top is 0.4 m high.
    pub fn table(&mut self) {
        self.table_of(Vector::new(1.3, 0.75, 0.2), Vector::new(0.25, 0.35, 0.2), with_friction);
    }

    /// A cube of 5 cm and 2 kg.
    pub fn block(&mut self) -> Body {
        let index = self.loose.len();
        let block = self.cube(RigidBodyBuilder::dynamic(), BLOCK_MASS);
        self.show(&format!("block_{}", index + 1), block, &[object_color(index)]);
        block
    }

    /// The cube of 5 cm and 4 kg in the drawer, which moves as if through honey.
    pub(crate) fn sluggish_block(&mut self) -> Body {
        let body = RigidBodyBuilder::dynamic()
            .linear_damping(SLUGGISH_DAMPING / SLUGGISH_MASS)
            .angular_damping(SLUGGISH_DAMPING / SLUGGISH_INERTIA);
        let block = self.cube(body, SLUGGISH_MASS);
        // The first object is the handle of the drawer.
        self.show("block", block, &[object_color(1)]);
        block
    }

    fn cube(&mut self, body: RigidBodyBuilder, mass: f32) -> Body {
        let half = BLOCK_EDGE / 2.0;
        let body = self.bodies.insert(body.can_sleep(false));
        let cube = rough(ColliderBuilder::cuboid(half, half, half)).mass(mass);
        self.colliders.insert_with_parent(cube, body, &mut self.bodies);
        self.loose(body)
    }

    /// Makes an action of 1 move the hand's target by `per_step` meters instead of 5 cm.
    pub(crate) fn slow_hand(&mut self, per_step: f32) {
        self.hand_range.per_step = per_step;
    }

    /// Lets no action bring the grip center below a height, in meters.
    pub(crate) fn keep_hand_above(&mut self, height: f32) {
        self.hand_range.corners[0].z = height;
    }

    /// The table of Drawer and `DrawerBox`: its top is 0.32 m high.
    pub(crate) fn cabinet_table(&mut self) {
        self.table_of(Vector::new(1.42, 0.75, 0.16), Vector::new(0.25, 0.35, 0.16), with_friction);
    }

    /// Moves the robot from where it stands in `FetchPush`, by meters: its arm reaches elsewhere.
    pub(crate) fn move_robot(&mut self, offset: Vector3<f32>) {
        self.robot += offset;
    }

    /// The table of Slide: its top is 0.4 m high, and slippery.
    pub(crate) fn slide_table(&mut self) {
        let half = Vector::new(0.625, 0.45, 0.2);
        self.table_of(Vector::new(1.3244, 0.7502, 0.2), half, slippery);
    }

    /// The table of Insert: its top is 0.36 m high.
    pub(crate) fn low_table(&mut self) {
        self.table_of(Vector::new(1.3, 0.75, 0.18), Vector::new(0.25, 0.35, 0.18), with_friction);
    }

    /// A slippery disc of 5 cm across, 4 cm high, 2 kg.
    pub(crate) fn puck(&mut self) -> Body {
        let body = self.bodies.insert(RigidBodyBuilder::dynamic().can_sleep(false));
        let disc = slippery(ColliderBuilder::cylinder(PUCK_HEIGHT / 2.0, PUCK_RADIUS))
            // The axis of Rapier's cylinders is y.
            .rotation(Vector::X * FRAC_PI_2)
            .mass(PUCK_MASS);
        self.colliders.insert_with_parent(disc, body, &mut self.bodies);
        self.show("puck", Body(body), &[object_color(0)]);
        self.loose(body)
    }

    /// A table of smooth wood: its top is 0.4 m high.
    pub(crate) fn wooden_table(&mut self) {
        let half = Vector::new(0.25, 0.35, 0.2);
        self.table_of(Vector::new(1.3, 0.75, 0.2), half, |top| top.friction(WOOD_ON_WOOD));
    }

    /// An upright cylinder of wood, of 5 cm across and 3 cm high.
    pub(crate) fn wooden_cylinder(&mut self) -> Body {
        let body = RigidBodyBuilder::dynamic().can_sleep(false).gravity_scale(CYLINDER_GRAVITY);
        let body = self.bodies.insert(body);
        let cylinder = ColliderBuilder::cylinder(CYLINDER_HEIGHT / 2.0, CYLINDER_RADIUS)
            // The axis of Rapier's cylinders is y.
            .rotation(Vector::X * FRAC_PI_2)
            .friction(WOOD_ON_WOOD)
            .mass(CYLINDER_MASS);
        self.colliders.insert_with_parent(cylinder, body, &mut self.bodies);
        self.show("cylinder", Body(body), &[object_color(0)]);
        self.loose(body)
    }

    /// Keeps the grip center in a box, from its lowest corner to its highest.
    pub(crate) fn limit_hand(&mut self, lowest: Position, highest: Position) {
        self.hand_range.corners = [glam(lowest.coords), glam(highest.coords)];
    }

    /// Says that a body can be moved freely.
    fn loose(&mut self, body: RigidBodyHandle) -> Body {
        self.loose.push(Loose::new(Body(body)));
        Body(body)
    }

    /// A box that stands in the way: 2 cm thick, 8 cm wide along y, 5 cm high. Nothing moves it.
    pub(crate) fn obstacle(&mut self) -> Body {
        let body = self.bodies.insert(RigidBodyBuilder::fixed());
        let [x, y, z] = OBSTACLE_HALF;
        let cuboid = ColliderBuilder::cuboid(x, y, z)
            .friction(OBSTACLE_FRICTION)
            .friction_combine_rule(CoefficientCombineRule::Min);
        self.colliders.insert_with_parent(cuboid, body, &mut self.bodies);
        self.show("obstacle", Body(body), &[FURNITURE]);
        Body(body)
    }

    /// A plate of 20 by 20 cm, 8 cm high, with a hole of 4 by 4 cm in its middle, which is the
    /// center of the body. Nothing moves it.
    pub(crate) fn plate_with_hole(&mut self) -> Body {
        const HALF: f32 = 0.1;
        const HOLE: f32 = 0.02;
        // Middle and half width of the rim on one side of the hole.
        const SIDE: f32 = f32::midpoint(HALF, HOLE);
        const RIM: f32 = (HALF - HOLE) / 2.0;
        let body = self.bodies.insert(RigidBodyBuilder::fixed());
        for (x, y, half_x, half_y) in [
            (-SIDE, 0.0, RIM, HALF),
            (SIDE, 0.0, RIM, HALF),
            (0.0, -SIDE, HOLE, RIM),
            (0.0, SIDE, HOLE, RIM),
        ] {
            let wall = with_friction(ColliderBuilder::cuboid(half_x, half_y, PLATE_HEIGHT / 2.0));
            let wall = rounded(wall).translation(Vector::new(x, y, 0.0));
            self.colliders.insert_with_parent(wall, body, &mut self.bodies);
        }
        self.show("plate", Body(body), &[FURNITURE]);
        Body(body)
    }

    /// A table, from its center, half its edges, and how its top is to the touch.
    fn table_of(
        &mut self,
        center: Vector,
        half: Vector,
        touch: impl FnOnce(ColliderBuilder) -> ColliderBuilder,
    ) {
        let table = touch(ColliderBuilder::cuboid(half.x, half.y, half.z)).translation(center);
        let table = self.colliders.insert(table);
        self.looks.push(Look::new("table", Solid::Ground(table), &[TABLE]));
    }

    /// Says how a body looks: the color of each of its colliders, the last being that of all
    /// others.
    pub(super) fn show(&mut self, name: &str, body: Body, colors: &[Color]) {
        self.looks.push(Look::new(name, Solid::Body(body.0), colors));
    }
}
