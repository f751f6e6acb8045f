//! The whole state of a learner as plain numbers.

use super::network::Shape;
use crate::config::AgentConfig;
use rand::Rng;
use serde::{Deserialize, Serialize};

/// A trained network, its target and its optimizer; every vector has the layout of `shape`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trained {
    /// What is where in the vectors.
    pub shape: Shape,
    /// The parameters that are trained.
    pub online: Vec<f32>,
    /// The target network's parameters, which move toward them.
    pub target: Vec<f32>,
    /// Adam's running mean of gradients.
    pub first_moment: Vec<f32>,
    /// Adam's running mean of squared gradients.
    pub second_moment: Vec<f32>,
    /// Adam steps taken.
    pub steps: u64,
}

impl Trained {
    fn new(shape: Shape, config: &AgentConfig, rng: &mut impl Rng) -> Self {
        let online = shape.draw(config.init, rng);
        let zeros = vec![0.0; online.len()];
        Self {
            shape,
            target: online.clone(),
            first_moment: zeros.clone(),
            second_moment: zeros,
            online,
            steps: 0,
        }
    }
}

impl Trained {
    /// The same network with other inputs: each of `inputs` is one of these, or a new one, which has
    /// no influence yet. Its optimizer starts anew.
    fn with_inputs(&self, inputs: &[Option<usize>]) -> Self {
        let shape = Shape { inputs: inputs.len(), ..self.shape.clone() };
        let first = self.shape.layers().swap_remove(0);
        let new = vec![0.0; first.outputs];
        let with_inputs = |parameters: &[f32]| {
            let (weight, rest) = parameters.split_at(first.weight.end);
            let rows: Vec<&[f32]> = weight.chunks_exact(first.outputs).collect();
            let rows = inputs.iter().map(|input| input.map_or(&*new, |input| rows[input]));
            rows.chain([rest]).flatten().copied().collect::<Vec<_>>()
        };
        let zeros = vec![0.0; shape.parameters()];
        Self {
            online: with_inputs(&self.online),
            target: with_inputs(&self.target),
            first_moment: zeros.clone(),
            second_moment: zeros,
            steps: 0,
            shape,
        }
    }
}

/// Everything a learner remembers: what a checkpoint keeps, and what engines exchange.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnerState {
    /// Input `[observation ‖ goal]`, output the action before its tanh.
    pub actor: Trained,
    /// Input `[observation ‖ goal ‖ action]`, output the return; one or two of them.
    pub critics: Vec<Trained>,
    /// Updates so far.
    pub updates: u64,
}

impl LearnerState {
    /// An untrained learner for network inputs and actions of these widths.
    pub fn new(config: &AgentConfig, input: usize, action: usize, rng: &mut impl Rng) -> Self {
        let hidden = || config.hidden.clone();
        let actor = Shape { inputs: input, hidden: hidden(), outputs: action, layer_norm: false };
        let critic = Shape {
            inputs: input + action,
            hidden: hidden(),
            outputs: 1,
            layer_norm: config.critic_layer_norm,
        };
        Self {
            actor: Trained::new(actor, config, rng),
            critics: (0..config.critics)
                .map(|_| Trained::new(critic.clone(), config, rng))
                .collect(),
            updates: 0,
        }
    }

    /// The same networks for other inputs: each of `inputs` is one of these, or a new one, which has
    /// no influence yet. Actions are the same; optimizers and counts start anew.
    #[must_use]
    pub fn with_inputs(&self, inputs: &[Option<usize>]) -> Self {
        let Shape { inputs: before, outputs: actions, .. } = self.actor.shape;
        let actions = (before..before + actions).map(Some);
        let with_actions: Vec<_> = inputs.iter().copied().chain(actions).collect();
        let critics = self.critics.iter();
        Self {
            actor: self.actor.with_inputs(inputs),
            critics: critics.map(|critic| critic.with_inputs(&with_actions)).collect(),
            updates: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Preset;
    use crate::learner::infer::Inference;
    use crate::seed::{Purpose, Seed};
    use rand::RngExt as _;

    const INPUTS: usize = 5;
    const ACTIONS: usize = 2;

    /// A learner, as if it had learned.
    fn learned() -> LearnerState {
        let mut config = Preset::Fast.config("law", 2).agent;
        config.hidden = vec![6, 7];
        let mut rng = Seed(1).stream(Purpose::Init, 0);
        let mut learner = LearnerState::new(&config, INPUTS, ACTIONS, &mut rng);
        let LearnerState { actor, critics, updates } = &mut learner;
        for network in critics.iter_mut().chain([actor]) {
            let Trained { online, target, first_moment, second_moment, steps, .. } = network;
            for vector in [online, target, first_moment, second_moment] {
                vector.fill_with(|| rng.random_range(-1.0..1.0));
            }
            *steps = 9;
        }
        *updates = 9;
        learner
    }

    #[test]
    fn the_same_inputs_are_the_same_networks_with_new_optimizers() {
        let before = learned();
        let after = before.with_inputs(&[0, 1, 2, 3, 4].map(Some));
        assert_eq!(after.updates, 0);
        let networks = |learner: &LearnerState| -> Vec<Trained> {
            learner.critics.iter().chain([&learner.actor]).cloned().collect()
        };
        assert_eq!(after.critics.len(), 2);
        for (before, after) in networks(&before).into_iter().zip(networks(&after)) {
            let zeros = vec![0.0; before.online.len()];
            let (first_moment, second_moment) = (zeros.clone(), zeros);
            assert_eq!(after, Trained { first_moment, second_moment, steps: 0, ..before });
        }
    }

    #[test]
    fn other_inputs_have_no_influence_and_known_ones_the_same_wherever_they_are() {
        let before = learned();
        let places = [Some(3), None, Some(0), Some(1), None, Some(2), None];
        let after = before.with_inputs(&places);
        let mut rng = Seed(2).stream(Purpose::Init, 0);
        let mut seen = [0.0; INPUTS];
        seen.fill_with(|| rng.random_range(-1.0..1.0));
        // This one is no input any more.
        seen[4] = 0.0;
        let action = [0.3, -0.8];
        let rewired: Vec<f32> = places
            .iter()
            .map(|place| place.map_or_else(|| rng.random_range(-5.0..5.0), |place| seen[place]))
            .collect();
        let output = |network: &Trained, parameters: &[f32], input: &[f32]| {
            let mut output = vec![0.0; network.shape.outputs];
            Inference::new(&network.shape).forward(parameters, input, &mut output);
            output
        };
        let pairs =
            before.critics.iter().zip(&after.critics).chain([(&before.actor, &after.actor)]);
        for (before, after) in pairs {
            let with_action = |seen: &[f32], network: &Trained| {
                let actions = if network.shape.outputs == 1 { &action[..] } else { &[] };
                [seen, actions].concat()
            };
            for target in [false, true] {
                let parameters =
                    |it: &Trained| if target { it.target.clone() } else { it.online.clone() };
                let expected = output(before, &parameters(before), &with_action(&seen, before));
                let found = output(after, &parameters(after), &with_action(&rewired, after));
                for (found, expected) in found.iter().zip(&expected) {
                    assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
                }
            }
        }
    }
}
