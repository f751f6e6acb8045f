//! What is deployed: a frozen policy, what acts with it, and its file.

mod critic;
mod file;

pub use critic::Critic;
pub use file::{Actor, Mismatch, Policy, PolicyError, PolicyInfo};
