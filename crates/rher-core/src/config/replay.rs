//! Settings of the replay buffer and of updates.

use super::declare::settings;
use crate::choice::choices;
use crate::setting::Range;

choices! {
    /// How the sub-tasks share an update.
    pub enum BatchMode {
        /// One update after the other, each with the rows of one sub-task: Algorithm 1, and the
        /// authors' single-object code.
        Separate = "separate",
        /// One update with the rows of all sub-tasks: the authors' multi-object code.
        Joint = "joint",
    }
}

settings! {
    /// Replay buffer and updates.
    pub struct ReplayConfig in "replay.", from start {
        /// Capacity of the replay buffer in transitions. Whole episodes are kept; the oldest make
        /// room for the newest.
        pub capacity: usize {
            range: Range::AtLeast(1),
            paper: 1_000_000,
        }
        /// Batch size: rows of each sub-task in an update. In a joint update it is the mean over
        /// the sub-tasks.
        pub batch_size: usize {
            range: Range::AtLeast(1),
            paper: if start.single { 256 } else { 2048 },
            fast: 128,
        }
        /// Fraction of a joint update's rows that is given to sub-tasks in proportion to their
        /// failure rates: prioritized sub-task sampling. The other rows are shared equally. Not in
        /// the paper.
        #[serde(default)]
        pub focus: f32 {
            range: Range::Share,
            paper: 0.0,
            fast: 0.5,
        }
        /// How the sub-tasks share an update (Algorithm 1).
        pub batch_mode: BatchMode {
            paper: if start.single { BatchMode::Separate } else { BatchMode::Joint },
            fast: BatchMode::Joint,
        }
        /// Rounds of updates after every episode. A round is one joint update, or one separate
        /// update of each sub-task.
        pub updates_per_episode: usize {
            range: Range::AtLeast(1),
            paper: 40,
            fast: match start.objects {
                1 => 80,
                2 => 40,
                _ => 20,
            },
            sample_efficient: 160,
        }
        /// Warm-up: training episodes before the first update.
        pub warmup_episodes: u64 {
            range: Range::TOML,
            paper: if start.single { 0 } else { 50 },
            fast: 0,
        }
    }
}
