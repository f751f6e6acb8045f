//! Things that are placed in a world.

use nalgebra::{UnitQuaternion, Vector3};
use rapier3d::prelude::RigidBodyHandle;
use rher_core::goal::Position;

/// A thing in a [`World`](super::World) that is placed when an episode begins.
#[derive(Clone, Copy, PartialEq)]
pub struct Body(pub(super) RigidBodyHandle);

/// Where a [`Body`] is and how it moves, in the world frame.
#[derive(Clone, Copy)]
pub struct Motion {
    /// Center, in meters.
    pub position: Position,
    /// Orientation; a block starts with none.
    pub rotation: UnitQuaternion<f32>,
    /// Meters per second.
    pub velocity: Vector3<f32>,
    /// Radians per second.
    pub spin: Vector3<f32>,
}

/// A body that can be moved freely.
#[derive(Clone, Copy)]
pub(super) struct Loose {
    pub(super) body: Body,
    /// How much higher its middle is than if it had its usual size, in meters.
    pub(super) raised: f32,
}

impl Loose {
    /// A body of its usual size.
    pub(super) fn new(body: Body) -> Self {
        Self { body, raised: 0.0 }
    }
}
