//! What is deployed: a frozen policy, what acts with it, and its file.

mod actor;
mod critic;
mod file;
mod info;
mod model;
#[cfg(feature = "onnx")]
mod onnx;
mod run_id;

pub use actor::Actor;
pub use critic::Critic;
pub use file::PolicyError;
pub use info::{Mismatch, PolicyInfo};
pub use model::Policy;
#[cfg(feature = "onnx")]
pub use onnx::{OnnxError, OnnxModel};
pub use run_id::{NoRunId, RunId};
