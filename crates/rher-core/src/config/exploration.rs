//! Settings of exploration.

use super::declare::settings;
use crate::choice::choices;
use crate::setting::Range;

choices! {
    /// Which policy acts before the object is reached: the cases of the paper's Table I.
    pub enum TrainPolicy {
        /// The guide and the learner, drawn at every step (eq. 10). This is the paper's.
        Mix = "mix",
        /// The guide only.
        Guide = "guide",
    }
}

choices! {
    /// Which policy is evaluated: the cases of the paper's Table I.
    pub enum TestPolicy {
        /// The policy of the sub-task under test, at every step. This is the paper's.
        Final = "final",
        /// The policy of the stage that the scene is in.
        Guide = "guide",
        /// One of the two at every step, with equal probability.
        Mix = "mix",
    }
}

settings! {
    /// Exploration: who chooses the actions of training episodes.
    pub struct ExplorationConfig in "exploration.", from start {
        /// Probability that the guide acts, the policy of a simpler sub-task: the paper's α
        /// (eq. 10, Section VI.D). α + β must be at most 1.
        pub guide: f32 {
            range: Range::Share,
            paper: 0.4,
        }
        /// Probability of a uniformly random action: the paper's β (eq. 10), the ε of ε-greedy
        /// exploration.
        pub random: f32 {
            range: Range::Share,
            paper: 0.2,
        }
        /// Mean number of steps for which a random action is repeated. β stays the share of all
        /// steps; 1 is the paper's.
        #[serde(default = "one_step")]
        pub random_steps: f32 {
            range: Range::AtLeast(1),
            paper: 1.0,
            fast: if start.single { 1.0 } else { 4.0 },
        }
        /// Standard deviation of the Gaussian noise on the actions that are not random. Actions
        /// range from −1 to 1.
        pub noise: f32 {
            range: Range::NonNegative,
            paper: 0.2,
        }
        /// Scale `random` and `noise` by 1 − success rate of the sub-task whose policy acts:
        /// adaptive exploration, called AAES in the authors' multi-object code.
        pub adjust_to_success: bool {
            paper: !start.single,
        }
        /// Success rate above which a sub-task becomes the guide: the paper's sr (Section IV.D).
        /// With 1 the first sub-task guides throughout.
        pub success_threshold: f32 {
            range: Range::Share,
            paper: if start.single { 1.0 } else { 0.8 },
        }
        /// Number of latest evaluations whose mean is the success rate of a sub-task, for the
        /// choice of the guide and for `adjust_to_success`.
        pub window: usize {
            range: Range::AtLeast(1),
            paper: 10,
            fast: if start.single { 10 } else { 5 },
        }
        /// Which policy acts in training before the object is reached (Table I).
        pub train_policy: TrainPolicy {
            paper: TrainPolicy::Mix,
        }
        /// Which policy is evaluated (Table I).
        pub test_policy: TestPolicy {
            paper: TestPolicy::Final,
        }
    }
}

/// The repetition of runs from before it was a setting.
fn one_step() -> f32 {
    1.0
}
