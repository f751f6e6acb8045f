//! How an episode went.

use rher_core::evaluate::Played;
use rher_core::goal::{EncodedGoal, Tolerances};

/// Whether the goal of an episode was met at its beginning and after each of its steps: `[T + 1]`.
pub(crate) fn solved<const N: usize>(
    Played { stage, episode, .. }: &Played<N>,
    tolerances: &Tolerances<N>,
) -> Vec<bool> {
    let is_met = |achieved| {
        EncodedGoal::new(*stage, achieved, &episode.desired).is_met(achieved, tolerances)
    };
    episode.achieved.iter().map(is_met).collect()
}
