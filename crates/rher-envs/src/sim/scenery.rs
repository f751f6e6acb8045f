//! What stands around the gripper.

use super::{Body, Scenery, glam};
use nalgebra::Vector3;
use rapier3d::prelude::{CoefficientCombineRule, ColliderBuilder, RigidBodyBuilder};
use rher_core::goal::Position;

/// Edge of a block, in metres.
pub(crate) const BLOCK_EDGE: f32 = 0.05;

/// Kilograms.
const BLOCK_MASS: f32 = 2.0;

impl Scenery {
    /// The ground on which what leaves the table ends up.
    pub(super) fn floor(&mut self) {
        self.fixed_box(Position::new(1.3, 0.75, -0.5), Vector3::new(10.0, 10.0, 0.5));
    }

    /// The table of every Fetch task but Slide: its top is 0.4 m high.
    pub(crate) fn table(&mut self) {
        self.fixed_box(Position::new(1.3, 0.75, 0.2), Vector3::new(0.25, 0.35, 0.2));
    }

    /// A cube of 5 cm and 2 kg.
    pub(crate) fn block(&mut self) -> Body {
        let half = BLOCK_EDGE / 2.0;
        let body = self.bodies.insert(RigidBodyBuilder::dynamic().can_sleep(false));
        let cube = with_friction(ColliderBuilder::cuboid(half, half, half)).mass(BLOCK_MASS);
        self.colliders.insert_with_parent(cube, body, &mut self.bodies);
        Body(body)
    }

    /// A box that nothing moves, from its centre and half its edges.
    fn fixed_box(&mut self, centre: Position, half: Vector3<f32>) {
        let cuboid = ColliderBuilder::cuboid(half.x, half.y, half.z);
        self.colliders.insert(with_friction(cuboid).translation(glam(centre.coords)));
    }
}

/// Friction 1 wherever this touches, unless the other side has more: `MuJoCo`'s rule.
pub(super) fn with_friction(collider: ColliderBuilder) -> ColliderBuilder {
    collider.friction(1.0).friction_combine_rule(CoefficientCombineRule::Max)
}
