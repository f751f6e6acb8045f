//! What an episode can be played again from, whatever the number of objects.

use super::ActionSource;

/// Everything that an episode depends on but its environment, and who chose its actions.
#[derive(Clone, Debug, PartialEq)]
pub struct ActionLog {
    /// Number of the episode among those of its run, counted from 0.
    pub number: u64,
    /// Seed that the environment was reset with.
    pub seed: u64,
    /// `[T, action_dim]`, as they were carried out: each number in [−1, 1].
    pub actions: Vec<f32>,
    /// `[T]`.
    pub decisions: Vec<Decision>,
}

/// Who chose an action, and what was hoped of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Who.
    pub source: ActionSource,
    /// Index of the sub-task whose policy it was; of the learner's where chance chose.
    pub subtask: usize,
    /// What the first critic expects of the action in that sub-task; `None` where there is no
    /// critic.
    pub value: Option<f32>,
}
