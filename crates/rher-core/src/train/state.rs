//! Everything of a run but its replay and its learner.

use super::tally::Tally;
use crate::config::TrainConfig;
use crate::event::Seconds;
use crate::explore::Curriculum;
use crate::input::InputEncoder;
use crate::policy::PolicyInfo;
use serde::{Deserialize, Serialize};

/// Everything of a run but its replay: what a checkpoint keeps beside it.
///
/// There are no generator states in it: random streams are functions of the counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct RunState {
    pub(super) config: TrainConfig,
    pub(super) info: PolicyInfo,
    pub(super) env_steps: u64,
    pub(super) episodes: u64,
    pub(super) updates: u64,
    pub(super) evaluations: u64,
    /// Final success rates of the last two evaluations, the newest last.
    pub(super) last_success: [f32; 2],
    pub(super) encoder: InputEncoder,
    pub(super) curriculum: Curriculum,
    pub(super) tally: Tally,
    pub(super) wall_s: f64,
    pub(super) seconds: Seconds,
}
