//! What a trained critic expects, for those who look on.

use crate::episode::Episode;
use crate::goal::{EncodedGoal, Stage};
use crate::input::InputEncoder;
use crate::learner::infer::Inference;
use crate::learner::network::Shape;

/// A frozen critic with everything it needs to judge actions.
#[derive(Clone, Debug, PartialEq)]
pub struct Critic {
    encoder: InputEncoder,
    shape: Shape,
    parameters: Vec<f32>,
}

impl Critic {
    /// A critic for inputs of `encoder`, with `parameters` in the layout of `shape`.
    pub fn new(encoder: InputEncoder, shape: Shape, parameters: Vec<f32>) -> Self {
        Self { encoder, shape, parameters }
    }

    /// The return it expects of every action of an episode, each for the sub-task that ends with
    /// its own of the `stages`: `[T]`.
    pub fn values<const N: usize>(&self, episode: &Episode<N>, stages: &[Stage<N>]) -> Vec<f32> {
        let Episode { desired, observations, achieved, actions, end: _ } = episode;
        let (observation, input) = (self.encoder.observation(), self.encoder.width());
        let mut rows = vec![0.0; stages.len() * self.shape.inputs];
        let steps = rows.chunks_exact_mut(self.shape.inputs).zip(stages).zip(achieved);
        let seen = observations.chunks_exact(observation);
        let done = actions.chunks_exact(self.shape.inputs - input);
        for (((row, stage), now), (seen, done)) in steps.zip(seen.zip(done)) {
            let (state, action) = row.split_at_mut(input);
            let goal = EncodedGoal::new(*stage, now, desired);
            self.encoder.write(seen, now, &goal, state);
            action.copy_from_slice(done);
        }
        let mut values = vec![0.0; stages.len()];
        Inference::new(&self.shape).forward(&self.parameters, &rows, &mut values);
        values
    }
}
