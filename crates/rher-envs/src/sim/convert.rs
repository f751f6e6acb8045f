//! Between Rapier's math, which is glam's, and nalgebra's.

use nalgebra::{Point3, Vector3};
use rapier3d::prelude::Vector;

pub(super) fn glam(v: Vector3<f32>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(super) fn nalgebra(v: Vector) -> Vector3<f32> {
    Vector3::new(v.x, v.y, v.z)
}

/// The same for a point.
pub(super) fn point(v: Vector) -> Point3<f32> {
    nalgebra(v).into()
}
