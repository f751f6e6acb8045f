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
}
