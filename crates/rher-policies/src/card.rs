//! What is known of a shipped policy.

use serde::{Deserialize, Serialize};

/// What is known of a shipped policy: how it was made, and how well it does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Card {
    /// Name of the task.
    pub task: String,
    /// What there is to do.
    pub about: String,
    /// The command that trains the same policy, bit for bit.
    pub command: String,
    /// Environment steps of training.
    pub env_steps: u64,
    /// Episodes of its judgment, which are none of those that training was judged by.
    pub episodes: usize,
    /// Seed of these episodes.
    pub env_seed: u64,
    /// Share of these episodes that ended with every object in its place.
    pub success: f32,
    /// Wilson's 95 % interval of `success`.
    pub ci95: [f64; 2],
    /// Share that ended every sub-task, from the first.
    pub subtasks: Vec<Option<f32>>,
    /// Mean distance of the objects to their targets at the end, in meters.
    pub final_distance: f32,
    /// Version of the program.
    pub rher: String,
    /// SHA-256 of the policy's file.
    pub policy_sha256: String,
    /// What it was made from, and how it may be used.
    pub provenance: String,
}
