//! Edges that nothing is caught on.
//!
//! Things that touch sink into each other by a fraction of a millimeter. Rapier pushes them apart
//! along the shortest way out, so that what slides over two flush boxes is stopped at their seam:
//! the shortest way out of a box that it has hardly entered is back.

use rapier3d::prelude::{ActiveHooks, ColliderBuilder, ContactModificationContext, PhysicsHooks};

/// How far two things have to overlap sideways to push each other, in meters: more than what a
/// hand sinks in when it presses.
const ROUNDING: f32 = 0.0005;

/// Drops contacts at the edges of [`rounded`] boxes.
pub(super) struct RoundedEdges;

impl PhysicsHooks for RoundedEdges {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let [one, other] = [context.collider1, context.collider2]
            .map(|collider| context.colliders[collider].compute_aabb());
        let overlap = one.maxs.min(other.maxs) - one.mins.max(other.mins);
        if let Some(contacts) = context.rigid_mut() {
            let facing = contacts.normal.abs().max_position();
            let mut sideways = (0..3).filter(|axis| *axis != facing);
            if sideways.any(|axis| overlap[axis] < ROUNDING) {
                contacts.solver_contacts.clear();
            }
        }
    }
}

/// Makes the edges of a box, which lies along the axes of the world and never turns, as if they
/// were rounded by half a millimeter.
pub(super) fn rounded(collider: ColliderBuilder) -> ColliderBuilder {
    collider.active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
}
