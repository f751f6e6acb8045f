//! The learner: a TD3 actor-critic on plain numbers. Nothing here knows a goal or `N`.

#[cfg(feature = "agent")]
pub mod adam;
#[cfg(feature = "agent")]
pub mod burn;
#[cfg(feature = "agent")]
pub mod fused;
#[cfg(feature = "agent")]
pub mod infer;
pub mod network;
pub mod state;

#[cfg(all(test, feature = "agent"))]
mod agreement;
#[cfg(all(test, feature = "agent"))]
mod contract;

/// The engine that `config` names, starting from `state`.
#[cfg(feature = "agent")]
pub fn engine(
    config: &crate::config::AgentConfig,
    state: state::LearnerState,
) -> Box<dyn state::Engine> {
    match config.engine {
        crate::config::EngineKind::Burn => Box::new(burn::BurnEngine::from_state(config, state)),
        crate::config::EngineKind::Fused => Box::new(fused::FusedEngine::from_state(config, state)),
    }
}
