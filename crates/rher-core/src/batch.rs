//! A batch of transitions as the networks take them; past it nothing knows `N`.

/// Rows for one update, in flat buffers that are reused from one draw to the next.
///
/// # Shapes
///
/// `inputs`, `next_inputs`, `simpler_inputs`: `[rows, input_dim]`; `actions`: `[rows, action_dim]`;
/// `rewards`, `imitates`: `[rows]`.
/// All are row-major. There is no end flag: a time-out is not an end, so every next state counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// Normalized observation and goal before the step.
    pub inputs: Vec<f32>,
    /// The action taken, in [−1, 1].
    pub actions: Vec<f32>,
    /// The sparse reward, 0 or −1.
    pub rewards: Vec<f32>,
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
