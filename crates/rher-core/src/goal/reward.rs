//! The sparse reward: a pure function of what was asked and what was reached.

use super::{Achieved, EncodedGoal, Position};

/// Reward of a step that ends with every slot of the goal met.
pub const SUCCESS: f32 = 0.0;

/// Reward of every other step.
pub const FAILURE: f32 = -1.0;

/// Whether two points are at most `tolerance` metres apart.
#[inline]
pub(crate) fn is_within(a: &Position, b: &Position, tolerance: f32) -> bool {
    nalgebra::distance(a, b) <= tolerance
}

/// How near counts as there, by slot, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances<const N: usize> {
    /// Of the gripper to the place it should reach.
    pub gripper: f32,
    /// Of each object to its target.
    pub objects: [f32; N],
}

impl<const N: usize> Tolerances<N> {
    /// The same tolerance for every slot.
    pub fn uniform(tolerance: f32) -> Self {
        Self { gripper: tolerance, objects: [tolerance; N] }
    }

    /// Whether an object at `position` is within its tolerance of `target`.
    pub fn placed(&self, object: usize, position: &Position, target: &Position) -> bool {
        is_within(position, target, self.objects[object])
    }

    /// Slot by slot: the gripper's, then the objects'.
    pub fn by_slot(&self) -> impl Iterator<Item = f32> {
        std::iter::once(self.gripper).chain(self.objects)
    }
}

impl<const N: usize> EncodedGoal<N> {
    /// Whether every slot that is not blank is within its tolerance.
    pub fn is_met(&self, achieved: &Achieved<N>, tolerances: &Tolerances<N>) -> bool {
        let scene = &achieved.0;
        let reached = std::iter::once(&scene.gripper).chain(&scene.objects);
        self.slots().zip(reached).zip(tolerances.by_slot()).all(|((slot, reached), tolerance)| {
            slot.is_none_or(|wanted| is_within(&wanted, reached, tolerance))
        })
    }

    /// The sparse reward of a step that ended at `achieved`: [`SUCCESS`] or [`FAILURE`].
    ///
    /// Eq. 3 with the sign of the paper's text and of both published codes.
    pub fn reward(&self, achieved: &Achieved<N>, tolerances: &Tolerances<N>) -> f32 {
        if self.is_met(achieved, tolerances) { SUCCESS } else { FAILURE }
    }
}
