//! What receives an observation, part by part.

use nalgebra::Vector3;
use rher_core::goal::Position;

/// What the next parts of an observation are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// No object, or all of them.
    Gripper,
    /// One, by its place in relay order.
    Object(usize),
    /// First − second of two of them.
    Between(usize, usize),
    /// Something that is no object, by its name.
    Scenery(&'static str),
}

/// Receives an observation, part by part, in the order of its numbers.
///
/// Every part says what it is of the subject that it is about: `velocity`, `from_gripper`. By this
/// name a run on one task finds it in another.
pub trait Sink {
    /// The parts that follow are about this; at the beginning they are about the gripper.
    ///
    /// Tasks with objects that are alike must say it for each of their objects.
    fn about(&mut self, _: Subject) {}

    /// The position of the gripper, in the world frame, in meters.
    fn gripper(&mut self, position: Position) {
        self.position("position", position);
    }

    /// The position of an object, by its place in relay order, in the world frame, in meters.
    fn object(&mut self, _index: usize, position: Position) {
        self.position("position", position);
    }

    /// Any other point in the world frame, in meters.
    fn position(&mut self, what: &str, position: Position);

    /// A difference of points, in meters; a `velocity`, in meters per step; or the `last_action`.
    fn vector(&mut self, what: &str, vector: Vector3<f32>);

    /// Angles, in radians, or a `spin`, in radians per step: their mirror image turns the other way.
    fn turn(&mut self, what: &str, turn: Vector3<f32>);

    /// One number for each finger: its `opening`, in meters, or its `velocity`, in meters per step.
    fn fingers(&mut self, what: &str, fingers: [f32; 2]);
}
