//! The paint of the things in a world.

use crate::thing::Color;
use rapier3d::prelude::{ColliderHandle, RigidBodyHandle};

pub(super) const TABLE: Color = [0.78, 0.70, 0.58, 1.0];
pub(super) const FURNITURE: Color = [0.55, 0.60, 0.66, 1.0];
pub(super) const DRAWER: Color = [0.90, 0.86, 0.76, 1.0];
pub(super) const METAL: Color = [0.66, 0.68, 0.72, 1.0];

/// One thing of a world and its paint.
pub(super) struct Look {
    pub(super) name: String,
    pub(super) solid: Solid,
    /// Of its colliders, in their order; the last one is that of all others.
    pub(super) colors: Vec<Color>,
}

#[derive(Clone, Copy)]
pub(super) enum Solid {
    Body(RigidBodyHandle),
    /// A collider without a body.
    Ground(ColliderHandle),
}

impl Look {
    pub(super) fn new(name: impl Into<String>, solid: Solid, colors: &[Color]) -> Self {
        Self { name: name.into(), solid, colors: colors.to_vec() }
    }
}
