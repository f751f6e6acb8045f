//! The learner: a TD3 actor-critic on Burn, and the policy that comes out of it.

pub mod config;
pub mod fused;
pub mod learner;
pub mod network;
