//! What an engine does with a learner: the update, and what it reports.

use super::state::LearnerState;
use crate::batch::Batch;

/// Adam's decay of the first moment.
pub const BETA_1: f32 = 0.9;
/// Adam's decay of the second moment.
pub const BETA_2: f32 = 0.999;
/// Adam's guard against division by zero.
pub const EPSILON: f32 = 1e-8;

/// What one update reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Mean squared Bellman error, summed over critics (eq. 1).
    pub critic: f32,
    /// Eq. 2 plus the weighted mean squared action; `None` when the actor was not updated.
    pub actor: Option<f32>,
    /// Mean of the first critic over the batch.
    pub q_mean: f32,
    /// Smallest of the first critic over the batch.
    pub q_min: f32,
    /// Largest of the first critic over the batch.
    pub q_max: f32,
    /// L2 norm of the critics' gradient.
    pub critic_gradient: f32,
    /// L2 norm of the actor's gradient; `None` when it was not updated.
    pub actor_gradient: Option<f32>,
}

/// A gradient holds NaN or an infinity; the network was not moved along it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the gradient of {network} is not finite, first in `{tensor}`")]
pub struct NotFinite {
    /// Such as `critic 1`.
    pub network: String,
    /// Such as `layers.2.weight`: of all such tensors the nearest to the loss.
    pub tensor: String,
}

impl NotFinite {
    /// Where the gradient of a network, in the layout of `shape`, is not finite.
    #[cfg(any(feature = "burn", feature = "fused"))]
    pub(super) fn find(
        network: &str,
        shape: &super::network::Shape,
        gradient: &[f32],
    ) -> Option<Self> {
        let mut tensors = shape.tensors().into_iter().rev();
        let bad =
            tensors.find(|tensor| gradient[tensor.range.clone()].iter().any(|x| !x.is_finite()));
        bad.map(|tensor| Self { network: network.to_owned(), tensor: tensor.name })
    }
}

/// Does the arithmetic of the learner.
///
/// One update is, in this order, with Q₁ and Q₂ the critics and ′ marking targets:
///
/// ```text
/// y       = clip(r + γ min(Q₁′, Q₂′)(s′, clip(π′(s′) + clip(σ ε, ±c), ±1)), [−1/(1−γ), 0])
/// critics   one Adam step on Σₖ mean (Qₖ(s, a) − y)²                               (eq. 1)
/// actor     every `policy_delay` updates, one Adam step on
///           −mean Q₁(s, π(s)) + action_l2 · mean π(s)²                               (eq. 2)
///           + imitation · mean m (π(s) − π(s₋))², where m is 1 in rows that imitate and 0
///           elsewhere, s₋ is s with the goal of the simpler sub-task, and π(s₋) is constant
/// targets   with `TargetEvery::Update`, whenever the actor moved: θ′ ← θ′ + rate (θ − θ′)
/// ```
///
/// The first update of a fresh learner is number 1; the actor moves when the number is a multiple
/// of `policy_delay`. The actor's loss uses the critics after their step.
pub trait Engine: Send {
    /// One update; `noise` holds standard normal draws ε, `[rows, action]`.
    ///
    /// # Errors
    ///
    /// When a gradient is not finite. All critics' gradients are checked before one of them moves;
    /// when the actor's is at fault, the critics have moved.
    fn update(&mut self, batch: &Batch, noise: &[f32]) -> Result<Losses, NotFinite>;

    /// Moves all target networks by `target_rate`: what ends an episode's updates with
    /// `TargetEvery::Episode`.
    fn move_targets(&mut self);

    /// The actor's trained parameters, in the layout of its [`Shape`](super::network::Shape).
    fn actor(&self) -> Vec<f32>;

    /// Those of its target.
    fn target_actor(&self) -> Vec<f32>;

    /// The first critic's trained parameters, in the layout of its [`Shape`](super::network::Shape).
    fn critic(&self) -> Vec<f32>;

    /// The whole state, for a checkpoint or another engine.
    fn state(&self) -> LearnerState;
}
