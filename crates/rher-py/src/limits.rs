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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_are_the_limits_and_nothing_is_outside() {
        let limits = Limits { low: vec![-0.1, 0.0, 0.3], high: vec![0.2, 1e6, 0.3] };
        let applied = |number: f32| {
            let mut action = [number; 3];
            limits.apply(&mut action);
            action
        };
        assert_eq!(applied(-1.0), [-0.1, 0.0, 0.3]);
        assert_eq!(applied(1.0), [0.2, 1e6, 0.3]);
        let [middle, half, same] = applied(0.0);
        assert!((middle - 0.05).abs() < 1e-7 && half == 5e5 && same == 0.3);
    }
}
