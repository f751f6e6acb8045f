//! What receives an observation, part by part.

use nalgebra::Vector3;
use rher_core::goal::Position;

/// Which objects the next parts of an observation are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// None, or all alike.
    Gripper,
    /// One, by its place in relay order.
    Object(usize),
    /// First − second of two of them.
    Between(usize, usize),
}

/// Receives an observation, part by part, in the order of its numbers.
pub trait Sink {
    /// The parts that follow are about these objects; at the beginning they are about none.
    ///
    /// Only tasks with objects that are alike need say it.
    fn about(&mut self, _: Subject) {}

    /// The position of the gripper, in the world frame, in meters.
    fn gripper(&mut self, position: Position) {
        self.position(position);
    }

    /// The position of an object, by its place in relay order, in the world frame, in meters.
    fn object(&mut self, _index: usize, position: Position) {
        self.position(position);
    }

    /// Any other point in the world frame, in meters.
    fn position(&mut self, position: Position);

    /// A difference of points, or a velocity.
    fn vector(&mut self, vector: Vector3<f32>);

    /// Angles or an angular velocity: their mirror image turns the other way.
    fn turn(&mut self, turn: Vector3<f32>);

    /// One number for each finger.
    fn fingers(&mut self, fingers: [f32; 2]);
}
