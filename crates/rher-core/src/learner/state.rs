//! The whole state of a learner as plain numbers, and what an engine does with it.

use super::network::Shape;
use crate::batch::Batch;
use crate::config::AgentConfig;
use rand::Rng;
use serde::{Deserialize, Serialize};

/// Adam's decay of the first moment.
pub const BETA_1: f32 = 0.9;
/// Adam's decay of the second moment.
pub const BETA_2: f32 = 0.999;
/// Adam's guard against division by zero.
pub const EPSILON: f32 = 1e-8;
/// Guard against division by zero in layer normalisation.
pub const NORM_EPSILON: f32 = 1e-5;

/// A trained network, its target and its optimiser; every vector has the layout of `shape`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trained {
    /// What is where in the vectors.
    pub shape: Shape,
    /// The parameters that are trained.
    pub online: Vec<f32>,
    /// The parameters that follow them.
    pub target: Vec<f32>,
    /// Adam's mean of gradients.
    pub first_moment: Vec<f32>,
    /// Adam's mean of squared gradients.
    pub second_moment: Vec<f32>,
    /// Adam steps taken.
    pub steps: u64,
}

impl Trained {
    fn new(shape: Shape, config: &AgentConfig, rng: &mut impl Rng) -> Self {
        let online = shape.draw(config.init, rng);
        let zeros = vec![0.0; online.len()];
        Self {
            shape,
            target: online.clone(),
            first_moment: zeros.clone(),
            second_moment: zeros,
            online,
            steps: 0,
        }
    }
}

/// Everything a learner remembers: what a checkpoint keeps, and what engines exchange.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnerState {
    /// Input `[observation ‖ goal]`, output the action before its tanh.
    pub actor: Trained,
    /// Input `[observation ‖ goal ‖ action]`, output the return; one or two of them.
    pub critics: Vec<Trained>,
    /// Updates so far.
    pub updates: u64,
}

impl LearnerState {
    /// An untrained learner for network inputs and actions of these widths.
    pub fn new(config: &AgentConfig, input: usize, action: usize, rng: &mut impl Rng) -> Self {
        let hidden = || config.hidden.clone();
        let actor = Shape { inputs: input, hidden: hidden(), outputs: action, layer_norm: false };
        let critic = Shape {
            inputs: input + action,
            hidden: hidden(),
            outputs: 1,
            layer_norm: config.critic_layer_norm,
        };
        Self {
            actor: Trained::new(actor, config, rng),
            critics: (0..config.critics)
                .map(|_| Trained::new(critic.clone(), config, rng))
                .collect(),
            updates: 0,
        }
    }
}

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
    #[cfg(feature = "agent")]
    pub(super) fn find(network: &str, shape: &Shape, gradient: &[f32]) -> Option<Self> {
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

    /// The actor's trained parameters, in the layout of its [`Shape`].
    fn actor(&mut self) -> &[f32];

    /// The whole state, for a checkpoint or another engine.
    fn state(&mut self) -> LearnerState;
}
