//! Settings of evaluation.

use super::declare::settings;
use crate::setting::Range;

settings! {
    /// Evaluation: the policy without exploration on fixed episodes, judged at their last step.
    pub struct EvaluationConfig in "evaluation.", from start {
        /// Training episodes between two evaluations.
        pub every_episodes: u64 {
            range: Range::AtLeast(1),
            paper: 50,
            fast: if start.objects > 2 { 100 } else { 50 },
        }
        /// Evaluation episodes of the last sub-task, the whole task.
        pub episodes: usize {
            range: Range::Between(1, 1_000_000),
            paper: 100,
        }
        /// Evaluation episodes of each earlier sub-task.
        pub subtask_episodes: usize {
            range: Range::Between(1, 1_000_000),
            paper: 20,
        }
        /// Seed of the evaluation episodes. Runs with the same number are evaluated on the same
        /// episodes, whatever their own seed.
        pub env_seed: u64 {
            range: Range::TOML,
            paper: 0,
        }
    }
}
