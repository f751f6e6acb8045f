//! Settings of the learner.

use serde::{Deserialize, Serialize};

/// The engine that computes updates; networks, losses and files are the same for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EngineKind {
    /// Burn's autodiff: the reference.
    Burn,
    /// Explicit forward and backward passes over preallocated buffers.
    Fused,
}

impl EngineKind {
    /// The engines that are part of this build; the features are named after them.
    pub const AVAILABLE: &[Self] = &[
        #[cfg(feature = "burn")]
        Self::Burn,
        #[cfg(feature = "fused")]
        Self::Fused,
    ];

    /// The engine of the presets: `Fused`, or `Burn` where only that one is part of this build.
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
    /// The engine that computes updates.
    pub engine: EngineKind,
    /// Widths of the hidden layers, of the actor and of each critic.
    pub hidden: Vec<usize>,
    /// How weights are drawn.
    pub init: Init,
    /// 2 for TD3 (the target is the smaller of two), 1 for DDPG.
    pub critics: usize,
    /// Layer normalization before every activation of the critics.
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
    /// Polyak step: the share of its distance to the trained networks that a target moves by.
    pub target_rate: f32,
    /// When they move.
    pub target_every: TargetEvery,
}

impl AgentConfig {
    /// TD3 with the settings of the authors' multi-object code.
    pub fn td3() -> Self {
        Self {
            engine: EngineKind::DEFAULT,
            hidden: vec![256; 2],
            init: Init::FanIn,
            critics: 2,
            critic_layer_norm: false,
            policy_delay: 2,
            target_noise: 0.2,
            target_noise_clip: 0.5,
            discount: 0.98,
            action_l2: 1.0,
            imitation: 0.0,
            actor_learning_rate: 1e-3,
            critic_learning_rate: 1e-3,
            target_rate: 0.01,
            target_every: TargetEvery::Update,
        }
    }

    /// DDPG with the settings of the authors' single-object code.
    pub fn ddpg() -> Self {
        Self {
            hidden: vec![256; 3],
            init: Init::Xavier,
            critics: 1,
            policy_delay: 1,
            target_noise: 0.0,
            target_rate: 0.05,
            target_every: TargetEvery::Episode,
            ..Self::td3()
        }
    }

    /// The lowest possible return, −1 / (1 − γ).
    pub fn lowest_return(&self) -> f32 {
        -1.0 / (1.0 - self.discount)
    }
}
