//! What is measured.

use std::fmt;

/// A part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Observations and scenes of episodes with fixed actions.
    Physics,
    /// A batch of their transitions with the goals of hindsight.
    Relabeling,
    /// Actions of an untrained network for that batch.
    Acting,
    /// A learner's whole state after updates in single precision.
    Update,
    /// The same with `agent.precision = "bf16"`.
    UpdateBf16,
    /// The policy of a short run.
    Run,
}

impl Part {
    /// All that this machine can do: a run needs threads.
    pub const ALL: &[Self] = &[
        Self::Physics,
        Self::Relabeling,
        Self::Acting,
        Self::Update,
        Self::UpdateBf16,
        #[cfg(not(target_family = "wasm"))]
        Self::Run,
    ];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Physics => "physics",
            Self::Relabeling => "relabeling",
            Self::Acting => "acting",
            Self::Update => "update",
            Self::UpdateBf16 => "update-bf16",
            Self::Run => "run",
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
