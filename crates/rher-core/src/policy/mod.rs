//! What is deployed: a frozen policy, what acts with it, and its file.

mod actor;
mod critic;
mod file;
mod info;
mod model;

pub use actor::Actor;
pub use critic::Critic;
pub use file::PolicyError;
pub use info::{Mismatch, PolicyInfo};
pub use model::Policy;
