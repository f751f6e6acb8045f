//! The sparse reward: a pure function of what was asked and what was reached.

use super::position::is_within;
use super::{Achieved, EncodedGoal, Tolerances};

/// Reward of a step that ends with every slot of the goal met.
pub const SUCCESS: f32 = 0.0;

/// Reward of every other step.
pub const FAILURE: f32 = -1.0;

impl<const N: usize> EncodedGoal<N> {
    /// Whether every slot that is not blank is met: its position and every part of its tail are within
    /// their tolerances.
    pub fn is_met(&self, achieved: &Achieved<N>, tolerances: &Tolerances<N>) -> bool {
        let scene = &achieved.0;
        let is_reached = self
            .gripper()
            .is_none_or(|wanted| is_within(&wanted, &scene.gripper, tolerances.gripper));
        is_reached
            && self.objects().iter().enumerate().all(|(object, slot)| {
                slot.is_none_or(|wanted| {
                    tolerances.is_there(object, (&wanted, self.tail(object)), scene)
                })
            })
    }

    /// The sparse reward of a step that ended at `achieved`: [`SUCCESS`] or [`FAILURE`].
    ///
    /// Eq. 3 with the sign of the paper's text and of both published codes.
    pub fn reward(&self, achieved: &Achieved<N>, tolerances: &Tolerances<N>) -> f32 {
        if self.is_met(achieved, tolerances) { SUCCESS } else { FAILURE }
    }
}
