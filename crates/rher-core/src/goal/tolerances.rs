//! How near counts as there.

use super::Position;

/// Whether two points are at most `tolerance` meters apart.
#[inline]
pub(crate) fn is_within(a: &Position, b: &Position, tolerance: f32) -> bool {
    nalgebra::distance(a, b) <= tolerance
}

/// How near counts as there, by slot, in meters.
///
/// ```
/// use rher_core::{Position, Tolerances};
///
/// let near = Position::new(0.04, 0.0, 0.0);
/// let tolerances = Tolerances::<1>::uniform(0.05);
/// assert!(tolerances.placed(0, &near, &Position::origin()));
/// ```
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
