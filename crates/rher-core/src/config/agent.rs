//! Settings of the learner.

use super::declare::settings;
use crate::choice::choices;
use crate::setting::Range;

choices! {
    /// Compute engine of the networks.
    pub enum EngineKind {
        /// Burn's automatic differentiation: the reference implementation.
        Burn = "burn",
        /// Explicit forward and backward passes over preallocated buffers: the fast implementation.
        Fused = "fused",
    }
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
}

choices! {
    /// What the matrix products of the hidden layers are computed from.
    pub enum Precision {
        /// Numbers of 32 bits.
        F32 = "f32",
        /// Numbers rounded to 16 bits (bfloat16), with sums of 32 bits: two thirds of the time of
        /// `f32` on a processor with AVX512-BF16; the same result, in up to a tenth more time than
        /// `f32`, on any other. Only the engine `fused` has it.
        Bf16 = "bf16",
    }
}

impl Precision {
    /// That of the presets but `paper`: `Bf16`, unless their engine does not have it.
    pub const DEFAULT: Self = match EngineKind::DEFAULT {
        EngineKind::Fused => Self::Bf16,
        EngineKind::Burn => Self::F32,
    };
}

/// That of every run from before there was a choice.
impl Default for Precision {
    fn default() -> Self {
        Self::F32
    }
}

choices! {
    /// Initialization of the networks.
    pub enum Init {
        /// Weights uniform in ±√(6 / (inputs + outputs)), biases 0 (Glorot): the authors'
        /// single-object code.
        Xavier = "xavier",
        /// Weights and biases uniform in ±1/√inputs, PyTorch's default: the authors' multi-object
        /// code.
        FanIn = "fan-in",
    }
}

choices! {
    /// When the target networks are updated.
    pub enum TargetEvery {
        /// With every update of the actor.
        Update = "update",
        /// Once after all updates of an episode, as the authors' single-object code does.
        Episode = "episode",
    }
}

choices! {
    /// Which actor is the policy of a run.
    pub enum Deployed {
        /// The trained one: the paper.
        Trained = "trained",
        /// Its target, a running mean: it does not jump from one update to the next.
        Target = "target",
    }
}

/// That of every run from before there was a choice.
impl Default for Deployed {
    fn default() -> Self {
        Self::Trained
    }
}

settings! {
    /// The actor-critic: TD3, or DDPG with one critic, no policy delay and no target noise.
    pub struct AgentConfig in "agent.", from start {
        /// Compute engine. Networks, losses and files are the same for both.
        pub engine: EngineKind {
            paper: EngineKind::DEFAULT,
        }
        /// Precision of the matrix products of the hidden layers. Parameters, the optimizer and
        /// everything else have 32 bits.
        #[serde(default, with = "crate::since_6")]
        pub precision: Precision {
            paper: Precision::F32,
            fast: Precision::DEFAULT,
        }
        /// Widths of the hidden layers, of the actor and of each critic.
        pub hidden: Vec<usize> {
            range: Range::Between(1, 65_536),
            paper: if start.single { vec![256; 3] } else { vec![256; 2] },
            fast: vec![256; 2],
        }
        /// Initialization of the networks.
        pub init: Init {
            paper: if start.single { Init::Xavier } else { Init::FanIn },
        }
        /// Number of critics: 2 for TD3, whose target is the smaller of two values (clipped double
        /// Q-learning), 1 for DDPG.
        pub critics: usize {
            range: Range::Between(1, 2),
            paper: if start.single { 1 } else { 2 },
            fast: 2,
        }
        /// Layer normalization before every activation of the critics. Not in the paper.
        pub critic_layer_norm: bool {
            paper: false,
            fast: true,
        }
        /// Critic updates for each update of the actor: TD3's delayed policy updates, 2 for TD3, 1
        /// for DDPG.
        pub policy_delay: u64 {
            range: Range::AtLeast(1),
            paper: if start.single { 1 } else { 2 },
            fast: 2,
        }
        /// Standard deviation of the noise on target actions: TD3's target policy smoothing, 0.2
        /// for TD3, 0 for none.
        pub target_noise: f32 {
            range: Range::NonNegative,
            paper: if start.single { 0.0 } else { 0.2 },
            fast: 0.2,
        }
        /// Bound at which the noise on target actions is clipped.
        pub target_noise_clip: f32 {
            range: Range::NonNegative,
            paper: 0.5,
        }
        /// Discount factor: the paper's γ (eq. 1). Targets are clipped to [−1 / (1 − γ), 0], the
        /// range of possible returns.
        pub discount: f32 {
            range: Range::ShareBelowOne,
            paper: 0.98,
            fast: 0.95,
        }
        /// Weight of the action penalty, the mean squared action, in the actor's loss (eq. 2).
        pub action_l2: f32 {
            range: Range::NonNegative,
            paper: 1.0,
            fast: if start.single { 1.0 } else { 0.1 },
        }
        /// Weight of the imitation of simpler sub-tasks in the actor's loss: self-distillation. It
        /// is the mean squared difference between the action and the one that the actor itself
        /// chooses for the simpler sub-task of the current object, over the rows where an earlier
        /// object is not placed. Not in the paper.
        #[serde(default)]
        pub imitation: f32 {
            range: Range::NonNegative,
            paper: 0.0,
            fast: 1.0,
        }
        /// Learning rate (Adam) of the actor.
        pub actor_learning_rate: f32 {
            range: Range::Positive,
            paper: 1e-3,
        }
        /// Learning rate (Adam) of the critics.
        pub critic_learning_rate: f32 {
            range: Range::Positive,
            paper: 1e-3,
        }
        /// Rate of the target networks' Polyak averaging, usually called τ: target ← τ · trained +
        /// (1 − τ) · target.
        pub target_rate: f32 {
            range: Range::PositiveShare,
            paper: if start.single { 0.05 } else { 0.01 },
            fast: 0.01,
        }
        /// When the target networks are updated.
        pub target_every: TargetEvery {
            paper: if start.single { TargetEvery::Episode } else { TargetEvery::Update },
            fast: TargetEvery::Update,
        }
        /// The actor that evaluations judge and the policy file has. Training episodes are played by
        /// the trained one. Not in the paper.
        #[serde(default, with = "crate::since_6")]
        pub deployed: Deployed {
            paper: Deployed::Trained,
            fast: Deployed::Target,
        }
    }
}

impl AgentConfig {
    /// The lowest possible return, −1 / (1 − γ).
    pub fn lowest_return(&self) -> f32 {
        -1.0 / (1.0 - self.discount)
    }

    /// The return of a reward that repeats forever.
    #[cfg(feature = "train")]
    pub(crate) fn repeated(&self, reward: f32) -> f32 {
        reward / (1.0 - self.discount)
    }
}
