//! The learner: a TD3 actor-critic on plain numbers. Nothing here knows a goal or `N`.

#[cfg(feature = "burn")]
pub mod burn;
#[cfg(feature = "train")]
pub mod engine;
#[cfg(feature = "train")]
pub mod engines;
#[cfg(feature = "fused")]
pub mod fused;
pub mod infer;
pub mod network;
pub mod simd;
pub mod state;

#[cfg(all(test, feature = "burn", feature = "fused"))]
mod agreement;
#[cfg(all(test, any(feature = "burn", feature = "fused")))]
mod contract;
