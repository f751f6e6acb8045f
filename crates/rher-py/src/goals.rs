//! How goals lie in the arrays of someone else's environment.

use rher_core::TailSpec;
use rher_core::goal::{Position, Tails};

/// The numbers of a goal: for one object after the other its position, where goals have positions,
/// and what else they say of it.
#[derive(Clone, Copy)]
pub(crate) struct GoalLayout {
    /// Numbers of a position.
    pub(crate) axes: usize,
    pub(crate) tail: TailSpec,
}

impl GoalLayout {
    /// Numbers of each object.
    pub(crate) fn width(&self) -> usize {
        self.position() + self.tail.numbers()
    }

    fn position(&self) -> usize {
        if self.tail.has_positions() { self.axes } else { 0 }
    }

    /// Where the objects are, as the goal of `N` objects in `row` says; `None` if it does not.
    pub(crate) fn positions<const N: usize>(&self, row: &[f32]) -> Option<[Position; N]> {
        let mut objects = row.chunks_exact(self.width());
        let mut next = || position(objects.next().unwrap_or_default(), self.axes);
        self.tail.has_positions().then(|| [(); N].map(|()| next()))
    }

    /// What else the goal of `N` objects in `row` says of them.
    pub(crate) fn tails<const N: usize>(&self, row: &[f32]) -> Tails<N> {
        if self.tail.is_none() {
            return Tails::default();
        }
        let objects = row.chunks_exact(self.width());
        let numbers: Vec<f32> =
            objects.flat_map(|object| &object[self.position()..]).copied().collect();
        Tails::read(&numbers, self.tail.numbers())
    }
}

/// The position at the beginning of `numbers`; one of two numbers has no height.
pub(crate) fn position(numbers: &[f32], axes: usize) -> Position {
    let mut position = Position::origin();
    position.coords.as_mut_slice()[..axes].copy_from_slice(&numbers[..axes]);
    position
}
