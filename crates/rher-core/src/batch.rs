//! A batch of transitions as the networks take them; past it nothing knows `N`.

/// Rows for one update, in flat buffers that are reused from one draw to the next.
///
/// # Shapes
///
/// `inputs`, `next_inputs`, `simpler_inputs`: `[rows, input_dim]`; `actions`: `[rows, action_dim]`;
/// `rewards`, `ended`, `imitates`: `[rows]`.
/// All are row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// Normalized observation and goal before the step.
    pub inputs: Vec<f32>,
    /// The action taken, in [−1, 1].
    pub actions: Vec<f32>,
    /// The sparse reward, 0 or −1.
    pub rewards: Vec<f32>,
    /// Whether nothing changes any more after the step: the reward then repeats forever, and no next
    /// state counts. A time-out is not such an end.
    pub ended: Vec<bool>,
    /// Normalized observation after the step, with the same goal.
    pub next_inputs: Vec<f32>,
    /// Whether there is a simpler sub-task whose turn it is: placing the first of the earlier
    /// objects that is not in its place.
    pub imitates: Vec<bool>,
    /// Normalized observation before the step, with the goal of that sub-task.
    pub simpler_inputs: Vec<f32>,
    /// Numbers in one row of `inputs`.
    pub input_dim: usize,
    /// Numbers in one row of `actions`.
    pub action_dim: usize,
}

impl Batch {
    /// A batch of zeros.
    pub fn zeros(rows: usize, input_dim: usize, action_dim: usize) -> Self {
        Self {
            inputs: vec![0.0; rows * input_dim],
            actions: vec![0.0; rows * action_dim],
            rewards: vec![0.0; rows],
            ended: vec![false; rows],
            next_inputs: vec![0.0; rows * input_dim],
            imitates: vec![false; rows],
            simpler_inputs: vec![0.0; rows * input_dim],
            input_dim,
            action_dim,
        }
    }

    /// How many transitions it holds.
    pub fn rows(&self) -> usize {
        self.rewards.len()
    }
}
