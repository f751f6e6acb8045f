//! The learner: a TD3 actor-critic on Burn, and the policy that comes out of it.

pub mod adam;
pub mod burn;
pub mod config;
pub mod infer;
pub mod learner;
pub mod network;

#[cfg(test)]
mod contract;
