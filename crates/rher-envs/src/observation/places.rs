//! Where in an observation the gripper's and the objects' positions are.

use super::sink::Sink;
use nalgebra::Vector3;
use rher_core::goal::Position;

/// Where in an observation positions are: the index of the first of three numbers each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places<const N: usize> {
    /// None if the observation does not have it.
    pub gripper: Option<usize>,
    /// In relay order; None where the observation does not have it.
    pub objects: [Option<usize>; N],
}

impl<const N: usize> Places<N> {
    /// Of an observation that has none, or of which it is not known.
    pub const fn unknown() -> Self {
        Self { gripper: None, objects: [None; N] }
    }
}

/// A [`Sink`] that learns where positions are.
pub(crate) struct Positions<const N: usize> {
    places: Places<N>,
    width: usize,
}

impl<const N: usize> Positions<N> {
    pub(crate) fn new() -> Self {
        Self { places: Places::unknown(), width: 0 }
    }

    /// Where they are.
    pub(crate) fn into_places(self) -> Places<N> {
        self.places
    }
}

impl<const N: usize> Sink for Positions<N> {
    fn gripper(&mut self, position: Position) {
        self.places.gripper.get_or_insert(self.width);
        self.position("position", position);
    }

    fn object(&mut self, index: usize, position: Position) {
        self.places.objects[index].get_or_insert(self.width);
        self.position("position", position);
    }

    fn position(&mut self, _: &str, _: Position) {
        self.width += 3;
    }

    fn vector(&mut self, _: &str, _: Vector3<f32>) {
        self.width += 3;
    }

    fn turn(&mut self, _: &str, _: Vector3<f32>) {
        self.width += 3;
    }

    fn fingers(&mut self, _: &str, _: [f32; 2]) {
        self.width += 2;
    }
}
