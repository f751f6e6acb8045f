//! What is deployed: a frozen policy, what acts with it, and its file.

mod critic;
mod policy;

pub use critic::Critic;
pub use policy::{About, Actor, Mismatch, Policy, PolicyError};
