//! Named starting points for the settings of a run.

use crate::choice::choices;

choices! {
    /// A named starting point for the settings of a run.
    ///
    /// The values of each preset stand beside the settings.
    pub enum Preset {
        /// Reaches the success rate in the least time on the user's machine.
        ///
        /// It differs from the paper by relative goals, near distances on a finer scale, rows drawn
        /// again whose hindsight goal is already met, mirrored batches, the two critics of TD3 with
        /// layer normalization, networks of two hidden layers, target networks that move with
        /// every update, γ = 0.95, d = 3 cm, and all sub-tasks in one joint batch of half the rows,
        /// with more of them for sub-tasks that still fail. With one object, it makes as many
        /// updates as the paper does for two sub-tasks, with two half and with more a quarter as
        /// many for the same data. With more objects than one, it has a smaller penalty on actions,
        /// sorts interchangeable objects by turn, imitates simpler sub-tasks, repeats random
        /// actions for a few steps, and lets the guide move on sooner.
        Fast = "fast",
        /// Reaches the success rate in the fewest environment steps.
        ///
        /// It is `fast` with twice the updates for one object, four times as many for two and eight
        /// times as many for more.
        SampleEfficient = "sample-efficient",
        /// The published settings.
        ///
        /// For one object they are those of the authors' single-object code, for more those of
        /// their multi-object code, but with the mean squared action as penalty and with every
        /// sub-task trained.
        Paper = "paper",
    }
}

/// What the values of a preset depend on.
pub(super) struct Start<'a> {
    pub(super) task: &'a str,
    pub(super) preset: Preset,
    pub(super) objects: usize,
    /// Whether there is one object.
    pub(super) single: bool,
}
