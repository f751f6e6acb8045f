//! What a policy was trained for, and whether an environment is that.

use crate::env::EnvSpec;
use crate::goal::Stage;
use serde::{Deserialize, Serialize};

/// What a policy was trained for.
///
/// ```no_run
/// # use rher_core::Policy;
/// let policy = Policy::load("policy.safetensors".as_ref())?;
/// println!("{} with {} objects", policy.info().task, policy.info().objects);
/// # Ok::<(), rher_core::PolicyError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolicyInfo {
    /// Name of the environment.
    pub task: String,
    /// Settings that the environment was made with, in its own words; empty where it has none.
    #[serde(default)]
    pub variant: String,
    /// Objects in the scene, the `N` of its types.
    pub objects: usize,
    /// Sub-tasks of the task, counted from the first.
    pub subtasks: usize,
    /// Sub-tasks before the first one that it was trained for: none, except for plain hindsight,
    /// which trains the last one alone.
    pub untrained: usize,
    /// Length of an observation.
    #[serde(rename = "observation")]
    pub obs_dim: usize,
    /// Length of an action.
    #[serde(rename = "action")]
    pub action_dim: usize,
    /// The paper's d, which separates reaching an object from moving it (eq. 6), in meters.
    pub reach_distance: f32,
}

impl PolicyInfo {
    /// The stage that ends the task; its sub-task is the whole task.
    ///
    /// # Errors
    ///
    /// When the policy is for another number of objects than `N`.
    pub fn last_stage<const N: usize>(&self) -> Result<Stage<N>, Mismatch> {
        check("objects", self.objects, N)?;
        let last = self.subtasks.checked_sub(1).and_then(Stage::from_index);
        last.ok_or_else(|| Mismatch::new("sub-tasks", &self.subtasks, &(2 * N)))
    }

    /// Whether environments like `spec` have its number of objects and its dimensions.
    pub(super) fn check_spec<const N: usize>(&self, spec: &EnvSpec<N>) -> Result<(), Mismatch> {
        check("objects", self.objects, N)?;
        check("obs_dim", self.obs_dim, spec.obs_dim)?;
        check("action_dim", self.action_dim, spec.action_dim)?;
        check("subtasks", self.subtasks, spec.subtasks)
    }
}

/// A policy does not fit an environment.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the policy does not fit the environment: {field} is {expected} in the policy and {given} in \
     the environment"
)]
pub struct Mismatch {
    /// What differs, such as `obs_dim`.
    pub field: &'static str,
    /// Its value in the policy.
    pub expected: String,
    /// Its value in the environment.
    pub given: String,
}

impl Mismatch {
    pub(super) fn new(
        field: &'static str,
        expected: &impl ToString,
        given: &impl ToString,
    ) -> Self {
        Self { field, expected: expected.to_string(), given: given.to_string() }
    }
}

fn check(field: &'static str, expected: usize, given: usize) -> Result<(), Mismatch> {
    if expected == given { Ok(()) } else { Err(Mismatch::new(field, &expected, &given)) }
}
