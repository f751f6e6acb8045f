//! Where something is, and whether that is near enough.

use nalgebra::Point3;

/// A point in the world frame, in meters.
///
/// ```
/// use rher_core::Position;
///
/// let above = Position::new(1.3, 0.7, 0.4) + rher_core::nalgebra::Vector3::z() * 0.1;
/// assert_eq!(above.z, 0.5);
/// ```
pub type Position = Point3<f32>;

/// Whether two points are at most `tolerance` meters apart.
#[inline]
pub(crate) fn is_within(a: &Position, b: &Position, tolerance: f32) -> bool {
    nalgebra::distance(a, b) <= tolerance
}

/// A tolerance to measure in: one of 0 is allowed, and is no unit.
pub(crate) fn unit(tolerance: f32) -> f32 {
    tolerance.max(0.001)
}
