//! How surfaces are to the touch.

use rapier3d::prelude::{CoefficientCombineRule, ColliderBuilder};

/// Coefficient of friction of the puck and of the table it slides on.
const SLIPPERY: f32 = 0.1;

/// Friction 1 wherever this touches, unless the other side has more: `MuJoCo`'s rule.
pub(super) fn with_friction(collider: ColliderBuilder) -> ColliderBuilder {
    rough(collider).friction_combine_rule(CoefficientCombineRule::Max)
}

/// Friction 1 against its like; what else it touches has the say.
pub(super) fn rough(collider: ColliderBuilder) -> ColliderBuilder {
    collider.friction(1.0)
}

/// Little friction, unless the other side has more.
pub(super) fn slippery(collider: ColliderBuilder) -> ColliderBuilder {
    collider.friction(SLIPPERY).friction_combine_rule(CoefficientCombineRule::Max)
}
