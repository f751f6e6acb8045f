//! The learner: a TD3 actor-critic, and the policy that comes out of it.

#[cfg(feature = "agent")]
pub mod adam;
#[cfg(feature = "agent")]
pub mod burn;
pub mod config;
#[cfg(feature = "agent")]
pub mod critic;
#[cfg(feature = "agent")]
pub mod fused;
#[cfg(feature = "agent")]
pub mod infer;
pub mod learner;
pub mod network;
#[cfg(feature = "agent")]
pub mod policy;

#[cfg(all(test, feature = "agent"))]
mod agreement;
#[cfg(all(test, feature = "agent"))]
mod contract;

/// The engine that `config` names, going on from `state`.
#[cfg(feature = "agent")]
pub fn engine(
    config: &config::AgentConfig,
    state: learner::LearnerState,
) -> Box<dyn learner::Engine> {
    match config.engine {
        config::EngineKind::Burn => Box::new(burn::BurnEngine::from_state(config, state)),
        config::EngineKind::Fused => Box::new(fused::FusedEngine::from_state(config, state)),
    }
}
