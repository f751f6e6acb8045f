//! What only pictures show: goals as ghosts, and an arm that holds the hand.

use super::room::Room;
use crate::simulated::Simulated;
use crate::thing::{Color, Form, Role, Shape, Thing, object_color};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rher_core::goal::{Achieved, Desired, Position};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Name of the arm.
pub(super) const ARM: &str = "arm";

/// How solid the ghost of an object is.
const GHOST: f32 = 0.45;

/// How solid lines are.
const LINE: f32 = 0.85;

/// Half the thickness of a line, in meters.
const HALF_LINE: f32 = 0.0018;

/// Largest radius of the mark of a goal that no object has the form of, in meters.
const LARGEST_MARK: f32 = 0.02;

/// What is nearer to the table than this needs no line to it, in meters.
const ON_TABLE: f32 = 0.03;

/// Everything that a picture of this moment shows: things, ghosts of objects where they should go
/// with rings as wide as their tolerance, and an arm; what is in the air has a line down to the
/// table.
///
/// `now` is what has been achieved, as the environment says.
pub fn scene<const N: usize>(
    env: &mut impl Simulated<N>,
    now: &Achieved<N>,
    desired: &Desired<N>,
) -> Vec<Thing> {
    let mut things = env.things();
    let Achieved(now) = env.truth().unwrap_or(*now);
    let table = things.iter().find(|thing| thing.name == "table");
    let table = table.map(|table| Room::around(table).top());
    let tolerances = env.spec().tolerances.objects;
    let mut marks = Vec::new();
    for (index, (place, tolerance)) in desired.objects().iter().zip(tolerances).enumerate() {
        let ghost = ghost(index, &things, &now.objects[index], place)
            .unwrap_or_else(|| mark(index, *place, tolerance));
        let bottom = Position::new(place.x, place.y, Room::around(&ghost).bottom());
        let color = translucent(object_color(index), LINE);
        let mut shapes = ring(bottom, tolerance, color);
        shapes.extend(table.and_then(|table| drop_line(bottom, table, color)));
        marks.push(ghost);
        marks.push(Thing::drawn(format!("tolerance_{}", index + 1), shapes));
    }
    if let Some(hand) = things.iter().find(|thing| thing.name == "hand") {
        let grip = Position::from(hand.pose.translation.vector);
        let line = table.and_then(|table| drop_line(grip, table, [0.08, 0.08, 0.1, 0.6]));
        marks.push(Thing::drawn("height".to_owned(), line.into_iter().collect()));
        let arm = arm(hand);
        things.push(arm);
    }
    things.extend(marks);
    things
}

impl Thing {
    /// A mark from shapes that have their places in the world.
    fn drawn(name: String, shapes: Vec<Shape>) -> Self {
        Self { name, role: Role::Mark, pose: Isometry3::identity(), shapes }
    }
}

/// The parts of things that have the color of an object, where the object should go.
fn ghost(index: usize, things: &[Thing], object: &Position, place: &Position) -> Option<Thing> {
    let color = object_color(index);
    let is_object = |shape: &&Shape| shape.color.as_slice() == color;
    let thing = things.iter().find(|thing| thing.shapes.iter().any(|shape| is_object(&shape)))?;
    let offset = thing.pose.translation.vector - object.coords;
    let shapes = thing.shapes.iter().filter(is_object);
    let shapes = shapes.map(|shape| Shape { color: translucent(color, GHOST), ..*shape }).collect();
    let pose = Isometry3::from(place.coords + offset);
    Some(Thing { name: format!("ghost_{}", index + 1), role: Role::Mark, pose, shapes })
}

/// A ball where something should be that has no form.
fn mark(index: usize, place: Position, tolerance: f32) -> Thing {
    let color = translucent(object_color(index), LINE);
    Thing::mark(format!("ghost_{}", index + 1), place, tolerance.min(LARGEST_MARK), color)
}

fn translucent([r, g, b, _]: Color, opacity: f32) -> Color {
    [r, g, b, opacity]
}

/// A flat ring.
fn ring(middle: Position, radius: f32, color: Color) -> Vec<Shape> {
    const SIDES: u8 = 32;
    let side = |index: u8| {
        let turn = UnitQuaternion::from_axis_angle(
            &Vector3::z_axis(),
            TAU * f32::from(index) / f32::from(SIDES),
        );
        let half_length = radius * FRAC_PI_2 * 2.0 / f32::from(SIDES);
        let pose = Isometry3::from_parts(Translation3::from(middle.coords), turn)
            * Translation3::new(radius, 0.0, HALF_LINE);
        let form = Form::Box(Vector3::new(HALF_LINE, half_length, HALF_LINE / 2.0));
        Shape { form, pose, color }
    };
    (0..SIDES).map(side).collect()
}

/// A line from a place down to a table, unless it is on the table.
fn drop_line(from: Position, table: f32, color: Color) -> Option<Shape> {
    let height = from.z - table;
    (height > ON_TABLE).then(|| Shape {
        form: Form::Cylinder { radius: HALF_LINE, height },
        pose: Isometry3::translation(from.x, from.y, table + height / 2.0),
        color,
    })
}

/// The last link of an arm and the joint at its end, from the top of a hand on.
fn arm(hand: &Thing) -> Thing {
    const LINK: Color = [0.86, 0.87, 0.89, 1.0];
    const JOINT: Color = [0.30, 0.42, 0.60, 1.0];
    const RADIUS: f32 = 0.024;
    const LENGTH: f32 = 0.22;
    /// Where the link goes: back to the robot, and up.
    const BACK: Vector3<f32> = Vector3::new(-0.18, 0.0, 1.0);
    let grip = hand.pose.translation.vector;
    let wrist = Point3::new(grip.x, grip.y, Room::around(hand).top());
    let along_y = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
    let back = BACK.normalize();
    let along_link = UnitQuaternion::rotation_between(&Vector3::z(), &back)
        .unwrap_or_else(UnitQuaternion::identity);
    let shape = |form, place: Point3<f32>, turn, color| Shape {
        form,
        pose: Isometry3::from_parts(Translation3::from(place), turn),
        color,
    };
    let joint = Form::Cylinder { radius: 1.15 * RADIUS, height: 2.5 * RADIUS };
    let link = Form::Cylinder { radius: RADIUS, height: LENGTH };
    Thing {
        name: ARM.to_owned(),
        role: Role::Moving,
        pose: Isometry3::identity(),
        shapes: vec![
            shape(joint, wrist, along_y, JOINT),
            shape(link, wrist + back * (LENGTH / 2.0), along_link, LINK),
            shape(joint, wrist + back * LENGTH, along_y, JOINT),
        ],
    }
}
