//! Between the actions of the method and those of an environment.

use serde::{Deserialize, Serialize};

/// Limits of the numbers of an action, which is within −1 and 1 to everyone but its environment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Limits {
    /// `[action_dim]`.
    pub(crate) low: Vec<f32>,
    /// `[action_dim]`.
    pub(crate) high: Vec<f32>,
}

impl Limits {
    /// Replaces an action whose numbers are in [−1, 1] by that of the environment.
    pub(crate) fn apply(&self, action: &mut [f32]) {
        for ((number, low), high) in action.iter_mut().zip(&self.low).zip(&self.high) {
            let share = 0.5 * (*number + 1.0);
            *number = (low * (1.0 - share) + high * share).clamp(*low, *high);
        }
    }
}
