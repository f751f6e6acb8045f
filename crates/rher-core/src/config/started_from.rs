//! The run that another run started from.

use crate::policy::RunId;
use serde::{Deserialize, Serialize};

/// The run whose networks another run started with: part of what that run is, but nothing that can be
/// set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartedFrom {
    /// Name of its environment.
    pub task: String,
    /// Its identity.
    pub run: RunId,
    /// Updates that it had made.
    pub updates: u64,
}
