//! Which engines there are.

use super::engine::Engine;
use super::simd::{Simd, SimdError};
use super::state::LearnerState;
use crate::config::{AgentConfig, EngineKind};

/// The engine that the settings name is not part of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the engine `{name}` is not part of this build: build with the feature `{name}`, or choose \
     another `agent.engine`",
    name = .0.name()
)]
pub struct MissingEngine(pub EngineKind);

/// A learner cannot compute on this machine.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EngineError {
    /// The engine that the settings name is not part of this build.
    #[error(transparent)]
    Missing(#[from] MissingEngine),
    /// The machine does not have the instructions that `RHER_SIMD` names.
    #[error(transparent)]
    Simd(#[from] SimdError),
}

/// Builds the engine that `config` names, with `state` as where it starts.
///
/// # Errors
///
/// When this build is without the feature that has the engine's name, or `RHER_SIMD` names
/// instructions that the machine does not have.
pub fn build(config: &AgentConfig, state: LearnerState) -> Result<Box<dyn Engine>, EngineError> {
    Simd::chosen()?;
    match config.engine {
        #[cfg(feature = "burn")]
        EngineKind::Burn => Ok(Box::new(super::burn::BurnEngine::from_state(config, state))),
        #[cfg(feature = "fused")]
        EngineKind::Fused => Ok(Box::new(super::fused::FusedEngine::from_state(config, state))),
        #[cfg(not(all(feature = "burn", feature = "fused")))]
        missing => {
            drop(state);
            Err(MissingEngine(missing).into())
        }
    }
}
