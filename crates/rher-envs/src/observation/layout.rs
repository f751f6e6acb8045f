//! The order of an observation's numbers, task by task, and what they are in a buffer and in a mirror.

use super::sink::{Sink, Subject};
use crate::sim::{Grip, Motion, STEP_SECONDS};
use nalgebra::{RealField, UnitQuaternion, Vector3};
use rher_core::env::SignedIndex;
use rher_core::goal::Position;

/// Writes the 25 numbers of `FetchPush`, `FetchPickAndPlace` and `FetchSlide`.
///
/// Gripper (3), object (3), object − gripper (3), finger openings (2), Euler angles of the object
/// (3), its velocity relative to the gripper's (3), its angular velocity (3), the gripper's
/// velocity (3), the fingers' (2). Meters and radians; velocities are per environment step.
pub fn gripper_and_object(grip: &Grip, object: &Motion, out: &mut impl Sink) {
    out.gripper(grip.position);
    out.object(0, object.position);
    out.about(Subject::Object(0));
    out.vector("from_gripper", object.position - grip.position);
    out.fingers("opening", grip.opening);
    turn_and_velocity(grip, object, out);
    grip_velocity(grip, out);
}

/// Writes the 43 numbers of the authors' `FetchDoublePush` and `FetchStack`.
///
/// Gripper (3), finger openings (2), 15 for each object ([`object_from_gripper`]), the gripper's
/// velocity (3), the fingers' (2), first − second object (3).
pub(crate) fn gripper_and_two_objects(grip: &Grip, objects: &[Motion; 2], out: &mut impl Sink) {
    out.gripper(grip.position);
    out.fingers("opening", grip.opening);
    for (index, object) in objects.iter().enumerate() {
        object_from_gripper(grip, index, object, out);
    }
    grip_velocity(grip, out);
    difference(objects, 0, 1, out);
}

/// Writes the 43 numbers of the authors' `DrawerBox`.
///
/// The 25 of [`gripper_and_object`] for the handle, block − gripper (3), [`turn_and_velocity`] of
/// the block (9), block (3), block − handle (3).
pub(crate) fn gripper_handle_and_block(
    grip: &Grip,
    handle: &Motion,
    block: &Motion,
    out: &mut impl Sink,
) {
    gripper_and_object(grip, handle, out);
    out.about(Subject::Object(1));
    out.vector("from_gripper", block.position - grip.position);
    turn_and_velocity(grip, block, out);
    out.object(1, block.position);
    out.about(Subject::Between(1, 0));
    out.vector("from", block.position - handle.position);
}

/// Writes the 69 numbers of the authors' `FetchThreePush`.
///
/// Gripper (3), finger openings (2), 15 for each of the first two objects
/// ([`object_from_gripper`]), the gripper's velocity (3), the fingers' (2), 15 for the third object,
/// first − second, second − third, first − third object (9), and both velocities again (5).
pub(crate) fn gripper_and_three_objects(grip: &Grip, objects: &[Motion; 3], out: &mut impl Sink) {
    out.gripper(grip.position);
    out.fingers("opening", grip.opening);
    object_from_gripper(grip, 0, &objects[0], out);
    object_from_gripper(grip, 1, &objects[1], out);
    grip_velocity(grip, out);
    object_from_gripper(grip, 2, &objects[2], out);
    for (one, other) in [(0, 1), (1, 2), (0, 2)] {
        difference(objects, one, other, out);
    }
    grip_velocity(grip, out);
}

/// Writes the 55 numbers of the authors' `FetchThreeStack`.
///
/// Finger openings (2), object − gripper (3) and [`turn_and_velocity`] (9) of each object, the
/// gripper's velocity (3), the fingers' (2), gripper (3), the objects (9).
pub(crate) fn gripper_and_stack(grip: &Grip, objects: &[Motion; 3], out: &mut impl Sink) {
    out.fingers("opening", grip.opening);
    for (index, object) in objects.iter().enumerate() {
        out.about(Subject::Object(index));
        out.vector("from_gripper", object.position - grip.position);
        turn_and_velocity(grip, object, out);
    }
    grip_velocity(grip, out);
    out.gripper(grip.position);
    for (index, object) in objects.iter().enumerate() {
        out.about(Subject::Object(index));
        out.object(index, object.position);
    }
}

/// Writes the 10 numbers of `FetchReach`: gripper (3), finger openings (2), the gripper's velocity
/// (3), the fingers' (2).
pub(crate) fn gripper_alone(grip: &Grip, out: &mut impl Sink) {
    out.gripper(grip.position);
    out.fingers("opening", grip.opening);
    grip_velocity(grip, out);
}

/// Writes 15 numbers: object (3), object − gripper (3), [`turn_and_velocity`] (9).
fn object_from_gripper(grip: &Grip, index: usize, object: &Motion, out: &mut impl Sink) {
    out.about(Subject::Object(index));
    out.object(index, object.position);
    out.vector("from_gripper", object.position - grip.position);
    turn_and_velocity(grip, object, out);
}

/// Writes 3 numbers: one object − another.
fn difference(objects: &[Motion], one: usize, other: usize, out: &mut impl Sink) {
    out.about(Subject::Between(one, other));
    out.vector("from", objects[one].position - objects[other].position);
}

/// Writes 9 numbers: the Euler angles of an object (3), its velocity relative to the gripper's (3),
/// its angular velocity (3).
fn turn_and_velocity(grip: &Grip, object: &Motion, out: &mut impl Sink) {
    out.turn("rotation", euler_angles(&object.rotation));
    out.vector("velocity", (object.velocity - grip.velocity) * STEP_SECONDS);
    out.turn("spin", object.spin * STEP_SECONDS);
}

/// Writes 5 numbers: the gripper's velocity (3), the fingers' (2).
fn grip_velocity(grip: &Grip, out: &mut impl Sink) {
    out.about(Subject::Gripper);
    out.vector("velocity", grip.velocity * STEP_SECONDS);
    out.fingers("velocity", grip.opening_velocity.map(|v| v * STEP_SECONDS));
}

/// Writes the 13 numbers of the authors' `FetchInsert`: the fingers' tip (3), the place of the
/// object (3), finger openings (2), the gripper's velocity (3), the fingers' (2).
pub(crate) fn tip_and_place(tip: Position, place: Position, grip: &Grip, out: &mut impl Sink) {
    out.gripper(tip);
    out.object(0, place);
    out.fingers("opening", grip.opening);
    grip_velocity(grip, out);
}

/// Writes the 18 numbers of `cue-push`: the cue's tip (3), object (3), object − tip (3), what the
/// tip has moved by in a step (3), and the object (3), the action that was chosen last (3).
///
/// A late camera shows where the cue was before that action.
pub(crate) fn cue_and_object(
    tip: &Grip,
    object: &Motion,
    chosen: Vector3<f32>,
    out: &mut impl Sink,
) {
    out.gripper(tip.position);
    out.object(0, object.position);
    out.about(Subject::Object(0));
    out.vector("from_gripper", object.position - tip.position);
    out.about(Subject::Gripper);
    out.vector("velocity", tip.velocity * STEP_SECONDS);
    out.about(Subject::Object(0));
    // Not relative to the gripper's, as it is elsewhere.
    out.vector("own_velocity", object.velocity * STEP_SECONDS);
    out.about(Subject::Gripper);
    out.vector("last_action", chosen);
}

/// Rotations about x, y and z, each about the axes as turned by those before it, in radians: the
/// convention of Gymnasium-Robotics.
fn euler_angles(rotation: &UnitQuaternion<f32>) -> Vector3<f32> {
    let m = rotation.to_rotation_matrix();
    // nalgebra's, since that of std differs between platforms.
    let angle = |sine: f32, cosine: f32| RealField::atan2(sine, cosine);
    let cos_pitch = (m[(2, 2)] * m[(2, 2)] + m[(1, 2)] * m[(1, 2)]).sqrt();
    let pitch = angle(m[(0, 2)], cos_pitch);
    if cos_pitch > 4.0 * f32::EPSILON {
        Vector3::new(angle(-m[(1, 2)], m[(2, 2)]), pitch, angle(-m[(0, 1)], m[(0, 0)]))
    } else {
        Vector3::new(0.0, pitch, angle(m[(1, 0)], m[(1, 1)]))
    }
}

/// A [`Sink`] that fills a buffer.
pub(crate) struct Numbers<'a> {
    buffer: &'a mut [f32],
    written: usize,
}

impl<'a> Numbers<'a> {
    /// Fills `buffer` from its beginning.
    pub(crate) fn new(buffer: &'a mut [f32]) -> Self {
        Self { buffer, written: 0 }
    }

    fn write(&mut self, numbers: &[f32]) {
        let end = self.written + numbers.len();
        self.buffer[self.written..end].copy_from_slice(numbers);
        self.written = end;
    }
}

impl Sink for Numbers<'_> {
    fn position(&mut self, _: &str, position: Position) {
        self.write(position.coords.as_slice());
    }

    fn vector(&mut self, _: &str, vector: Vector3<f32>) {
        self.write(vector.as_slice());
    }

    fn turn(&mut self, _: &str, turn: Vector3<f32>) {
        self.write(turn.as_slice());
    }

    fn fingers(&mut self, _: &str, fingers: [f32; 2]) {
        self.write(&fingers);
    }
}

/// A [`Sink`] that learns how each number is mirrored at a plane of constant x or y.
pub(crate) struct Reflections {
    images: Vec<SignedIndex>,
    axis: usize,
    plane: f32,
}

impl Reflections {
    /// For the plane where x (axis 0) or y (axis 1) is `plane`, in meters.
    pub(crate) fn new(axis: usize, plane: f32) -> Self {
        Self { images: Vec::new(), axis, plane }
    }

    /// One entry for each number of the observation.
    pub(crate) fn into_vec(self) -> Vec<SignedIndex> {
        self.images
    }

    /// Three numbers; those along the axis that is flipped have `flipped`, the others `kept`.
    fn add(&mut self, flipped: (f32, f32), kept: f32) {
        let from = self.images.len();
        let image = |axis| {
            let (sign, offset) = if axis == self.axis { flipped } else { (kept, 0.0) };
            SignedIndex { from: from + axis, sign, offset }
        };
        self.images.extend([0, 1, 2].map(image));
    }
}

impl Sink for Reflections {
    fn position(&mut self, _: &str, _: Position) {
        self.add((-1.0, 2.0 * self.plane), 1.0);
    }

    fn vector(&mut self, _: &str, _: Vector3<f32>) {
        self.add((-1.0, 0.0), 1.0);
    }

    fn turn(&mut self, _: &str, _: Vector3<f32>) {
        self.add((1.0, 0.0), -1.0);
    }

    fn fingers(&mut self, _: &str, _: [f32; 2]) {
        let first = self.images.len();
        // They open along y.
        let swapped = if self.axis == 1 { [first + 1, first] } else { [first, first + 1] };
        self.images.extend(swapped.map(|from| SignedIndex { from, sign: 1.0, offset: 0.0 }));
    }
}
