//! Settings of the learner.

use serde::{Deserialize, Serialize};

/// Who does the arithmetic of an update; networks, losses and files are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EngineKind {
    /// Burn's autodiff: the reference.
    Burn,
    /// Explicit forward and backward passes over preallocated buffers.
    Fused,
}

impl EngineKind {
    /// The engine of the presets: `Fused`, or `Burn` where only that one is compiled in.
    pub const DEFAULT: Self =
        if cfg!(all(feature = "burn", not(feature = "fused"))) { Self::Burn } else { Self::Fused };

    /// Name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Burn => "burn",
            Self::Fused => "fused",
        }
    }
}

/// How weights are drawn before the first update.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Init {
    /// Uniform in ±√(6 / (inputs + outputs)), biases 0: the authors' single-object code.
    Xavier,
    /// Uniform in ±1/√inputs, biases too: PyTorch's default, the authors' multi-object code.
    FanIn,
}

/// When the target networks move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TargetEvery {
    /// With every update of the actor.
    Update,
    /// Once after all updates of an episode, as the authors' single-object code.
    Episode,
}

/// Settings of the actor-critic: TD3, or DDPG with one critic, no delay and no smoothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AgentConfig {
    /// Who does the arithmetic.
    pub engine: EngineKind,
    /// Widths of the hidden layers, of the actor and of each critic.
    pub hidden: Vec<usize>,
    /// How weights are drawn.
    pub init: Init,
    /// 2 for TD3 (the target is the smaller of two), 1 for DDPG.
    pub critics: usize,
    /// Layer normalisation before every activation of the critics.
    pub critic_layer_norm: bool,
    /// Updates of the critics for one of the actor: 2 for TD3, 1 for DDPG.
    pub policy_delay: u64,
    /// Standard deviation of the noise on target actions: 0.2 for TD3, 0 for none.
    pub target_noise: f32,
    /// Largest noise on a target action.
    pub target_noise_clip: f32,
    /// The paper's γ; targets are clipped to [−1 / (1 − γ), 0], the range of possible returns.
    pub discount: f32,
    /// Weight of the mean squared action in the actor's loss.
    pub action_l2: f32,
    /// Weight, in the actor's loss, of how far it is from what it does itself for the simpler
    /// sub-task whose turn it is: the mean squared difference of actions, summed over the rows
    /// where an earlier object is not in its place.
    #[serde(default)]
    pub imitation: f32,
    /// Adam's step size for the actor.
    pub actor_learning_rate: f32,
    /// Adam's step size for the critics.
    pub critic_learning_rate: f32,
    /// Share of the way that the target networks move towards the trained ones.
    pub target_rate: f32,
    /// When they move.
    pub target_every: TargetEvery,
}

impl AgentConfig {
    /// The lowest possible return, −1 / (1 − γ).
    pub fn lowest_return(&self) -> f32 {
        -1.0 / (1.0 - self.discount)
    }
}
