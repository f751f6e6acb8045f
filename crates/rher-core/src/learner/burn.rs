//! The reference engine: Burn's modules and autodiff, one explicit graph per loss.

use super::adam::squared_norm;
use super::engine::{Engine, Losses, NotFinite};
use super::network::{self, NORM_EPSILON, Shape};
use super::state::{LearnerState, Trained};
use crate::batch::Batch;
use crate::config::{AgentConfig, TargetEvery};
use burn::backend::{Autodiff, NdArray};
use burn::module::{Module, ModuleVisitor, Param};
use burn::nn::{LayerNorm, LayerNormConfig, Linear};
use burn::tensor::activation::relu;
use burn::tensor::backend::{AutodiffBackend, Backend};
use burn::tensor::{Tensor, TensorData};
use std::ops::Range;

/// The engine on Burn's CPU backend.
pub type BurnEngine = AutodiffEngine<Autodiff<NdArray<f32>>>;

/// The engine on any of Burn's backends with autodiff.
///
/// Between updates everything is plain numbers; an update makes modules of them, which is cheap
/// beside what it does with them.
#[derive(Debug)]
pub struct AutodiffEngine<B: AutodiffBackend> {
    config: AgentConfig,
    state: LearnerState,
    device: B::Device,
}

impl<B: AutodiffBackend> AutodiffEngine<B> {
    /// An engine that goes on from `state`, on the backend's default device.
    pub fn from_state(config: &AgentConfig, state: LearnerState) -> Self {
        Self { config: config.clone(), state, device: B::Device::default() }
    }

    /// The return that the critics are to predict, `[rows, 1]`.
    fn bellman(&self, batch: &Batch, noise: &[f32]) -> Tensor<B::InnerBackend, 2> {
        let rows = batch.rows();
        let (spread, clip) = (self.config.target_noise, self.config.target_noise_clip);
        let target =
            |trained: &Trained| Network::new(&trained.shape, &trained.target, &self.device);
        let noise = noise.iter().map(|draw| (spread * draw).clamp(-clip, clip)).collect();
        let noise = matrix(noise, rows, &self.device);
        let inputs = matrix(batch.next_inputs.clone(), rows, &self.device);
        let actions = target(&self.state.actor).forward(inputs.clone()).tanh();
        let inputs = Tensor::cat(vec![inputs, (actions + noise).clamp(-1.0, 1.0)], 1);
        let values = self.state.critics.iter().map(|critic| target(critic).forward(inputs.clone()));
        let value = values.reduce(Tensor::min_pair).expect("a learner has a critic");
        let rewards = matrix(batch.rewards.clone(), rows, &self.device);
        (rewards + value * self.config.discount).clamp(self.config.lowest_return(), 0.0)
    }

    /// The critics' Adam step.
    fn train_critics(
        &mut self,
        batch: &Batch,
        returns: Tensor<B::InnerBackend, 2>,
    ) -> Result<Losses, NotFinite> {
        let rows = batch.rows();
        let inputs = matrix(batch.inputs.clone(), rows, &self.device);
        let actions = matrix(batch.actions.clone(), rows, &self.device);
        let inputs = Tensor::<B, 2>::cat(vec![inputs, actions], 1);
        let returns = Tensor::from_inner(returns);
        let mut losses = Losses::default();
        let mut squares = 0.0;
        let mut gradients = Vec::with_capacity(self.state.critics.len());
        for (index, critic) in self.state.critics.iter().enumerate() {
            let network = Network::new(&critic.shape, &critic.online, &self.device);
            let values = network.forward(inputs.clone());
            if index == 0 {
                let values = numbers(values.clone().inner());
                losses.q_mean = values.iter().sum::<f32>() / rows as f32;
                losses.q_min = values.iter().copied().fold(f32::INFINITY, f32::min);
                losses.q_max = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            }
            let errors = values - returns.clone();
            let loss = (errors.clone() * errors).mean();
            let gradient =
                network.gradient(&loss, &format!("critic {}", index + 1), &critic.shape)?;
            losses.critic += number(loss);
            squares += squared_norm(&gradient);
            gradients.push(gradient);
        }
        for (critic, gradient) in self.state.critics.iter_mut().zip(&gradients) {
            critic.descend(gradient, self.config.critic_learning_rate);
        }
        losses.critic_gradient = squares.sqrt();
        Ok(losses)
    }

    /// The actor's Adam step; gives its loss and the norm of its gradient.
    fn train_actor(&mut self, batch: &Batch) -> Result<(f32, f32), NotFinite> {
        let critic = &self.state.critics[0];
        let critic = Network::<B>::new(&critic.shape, &critic.online, &self.device).no_grad();
        let actor = &mut self.state.actor;
        let network = Network::new(&actor.shape, &actor.online, &self.device);
        let inputs = matrix(batch.inputs.clone(), batch.rows(), &self.device);
        let actions = network.forward(inputs.clone()).tanh();
        let effort = (actions.clone() * actions.clone()).mean();
        let simpler = matrix(batch.simpler_inputs.clone(), batch.rows(), &self.device);
        let imitates = batch.imitates.iter().map(|imitates| f32::from(u8::from(*imitates)));
        let imitates = matrix(imitates.collect(), batch.rows(), &self.device);
        let apart = (actions.clone() - network.forward(simpler).tanh().detach()) * imitates;
        let apart = (apart.clone() * apart).mean();
        let value = critic.forward(Tensor::cat(vec![inputs, actions], 1)).mean();
        let loss = effort * self.config.action_l2 + apart * self.config.imitation - value;
        let gradient = network.gradient(&loss, "the actor", &actor.shape)?;
        actor.descend(&gradient, self.config.actor_learning_rate);
        Ok((number(loss), squared_norm(&gradient).sqrt()))
    }
}

impl<B: AutodiffBackend> Engine for AutodiffEngine<B> {
    fn update(&mut self, batch: &Batch, noise: &[f32]) -> Result<Losses, NotFinite> {
        let returns = self.bellman(batch, noise);
        let mut losses = self.train_critics(batch, returns)?;
        self.state.updates += 1;
        if self.state.updates.is_multiple_of(self.config.policy_delay) {
            let (loss, gradient) = self.train_actor(batch)?;
            losses.actor = Some(loss);
            losses.actor_gradient = Some(gradient);
            if self.config.target_every == TargetEvery::Update {
                self.move_targets();
            }
        }
        Ok(losses)
    }

    fn move_targets(&mut self) {
        let networks = std::iter::once(&mut self.state.actor).chain(&mut self.state.critics);
        networks.for_each(|trained| trained.follow(self.config.target_rate));
    }

    fn actor(&self) -> Vec<f32> {
        self.state.actor.online.clone()
    }

    fn critic(&self) -> Vec<f32> {
        self.state.critics[0].online.clone()
    }

    fn state(&self) -> LearnerState {
        self.state.clone()
    }
}

/// A fully connected network; fields are in the order of the flat parameters.
#[derive(Module, Debug)]
struct Network<B: Backend> {
    hidden: Vec<Hidden<B>>,
    output: Linear<B>,
}

/// A rectified layer.
#[derive(Module, Debug)]
struct Hidden<B: Backend> {
    linear: Linear<B>,
    norm: Option<LayerNorm<B>>,
}

impl<B: Backend> Network<B> {
    fn new(shape: &Shape, parameters: &[f32], device: &B::Device) -> Self {
        let mut layers = shape.layers();
        let output = layers.pop().expect("a network has a layer");
        Self {
            hidden: layers.iter().map(|layer| Hidden::new(layer, parameters, device)).collect(),
            output: linear(&output, parameters, device),
        }
    }

    /// Outputs, `[rows, outputs]`, of inputs, `[rows, inputs]`.
    fn forward(&self, inputs: Tensor<B, 2>) -> Tensor<B, 2> {
        let features = self.hidden.iter().fold(inputs, |inputs, layer| layer.forward(inputs));
        self.output.forward(features)
    }
}

impl<B: AutodiffBackend> Network<B> {
    /// The slope of `loss` in every parameter, in the flat layout of `shape`.
    fn gradient(
        &self,
        loss: &Tensor<B, 1>,
        name: &str,
        shape: &Shape,
    ) -> Result<Vec<f32>, NotFinite> {
        let mut gather =
            Gather::<B> { slopes: loss.backward(), flat: Vec::with_capacity(self.num_params()) };
        self.visit(&mut gather);
        NotFinite::find(name, shape, &gather.flat).map_or(Ok(gather.flat), Err)
    }
}

impl<B: Backend> Hidden<B> {
    fn new(layer: &network::Layer, parameters: &[f32], device: &B::Device) -> Self {
        let norm = layer.norm.as_ref().map(|(scale, shift)| {
            let epsilon = f64::from(NORM_EPSILON);
            let mut norm = LayerNormConfig::new(layer.outputs).with_epsilon(epsilon).init(device);
            norm.gamma = vector(parameters, scale, device);
            norm.beta = Some(vector(parameters, shift, device));
            norm
        });
        Self { linear: linear(layer, parameters, device), norm }
    }

    fn forward(&self, inputs: Tensor<B, 2>) -> Tensor<B, 2> {
        let sums = self.linear.forward(inputs);
        relu(match &self.norm {
            Some(norm) => norm.forward(sums),
            None => sums,
        })
    }
}

/// Appends the slopes of one parameter after the other.
struct Gather<B: AutodiffBackend> {
    slopes: B::Gradients,
    flat: Vec<f32>,
}

impl<B: AutodiffBackend> ModuleVisitor<B> for Gather<B> {
    fn visit_float<const D: usize>(&mut self, parameter: &Param<Tensor<B, D>>) {
        let slopes = parameter.val().grad_remove(&mut self.slopes);
        self.flat.extend(numbers(slopes.expect("the loss depends on every parameter")));
    }
}

fn linear<B: Backend>(layer: &network::Layer, parameters: &[f32], device: &B::Device) -> Linear<B> {
    let weight =
        TensorData::new(parameters[layer.weight.clone()].to_vec(), [layer.inputs, layer.outputs]);
    Linear {
        weight: Param::from_data(weight, device),
        bias: Some(vector(parameters, &layer.bias, device)),
    }
}

fn vector<B: Backend>(
    parameters: &[f32],
    range: &Range<usize>,
    device: &B::Device,
) -> Param<Tensor<B, 1>> {
    Param::from_data(&parameters[range.clone()], device)
}

fn matrix<B: Backend>(values: Vec<f32>, rows: usize, device: &B::Device) -> Tensor<B, 2> {
    let columns = values.len() / rows;
    Tensor::from_data(TensorData::new(values, [rows, columns]), device)
}

fn numbers<B: Backend, const D: usize>(tensor: Tensor<B, D>) -> Vec<f32> {
    let data = tensor.into_data().convert::<f32>();
    data.into_vec().expect("converted just now")
}

fn number<B: Backend>(tensor: Tensor<B, 1>) -> f32 {
    numbers(tensor)[0]
}

#[cfg(test)]
mod tests {
    use super::super::contract;
    use super::super::infer::Inference;
    use super::*;
    use crate::config::Init;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn gradients_are_slopes_of_the_losses() {
        contract::gradients_are_slopes_of_the_losses(BurnEngine::from_state);
    }

    #[test]
    fn a_copy_of_the_state_goes_on_alike() {
        contract::a_copy_of_the_state_goes_on_alike(BurnEngine::from_state);
    }

    #[test]
    fn a_gradient_that_is_none_is_located_and_moves_nothing() {
        contract::a_gradient_that_is_none_is_located_and_moves_nothing(BurnEngine::from_state);
    }

    #[test]
    fn values_are_the_known_returns() {
        contract::values_are_the_known_returns(BurnEngine::from_state);
    }

    #[test]
    fn the_actor_finds_the_rewarded_action() {
        contract::the_actor_finds_the_rewarded_action(BurnEngine::from_state);
    }

    #[test]
    fn acting_and_training_see_the_same_network() {
        for (hidden, layer_norm) in [(vec![256; 3], false), (vec![37, 5], true), (vec![], false)] {
            let shape = Shape { inputs: 31, hidden, outputs: 4, layer_norm };
            let mut rng = ChaCha8Rng::seed_from_u64(8);
            let parameters = shape.draw(Init::FanIn, &mut rng);
            let inputs: Vec<f32> = (0..19 * 31).map(|_| rng.random_range(-5.0..5.0)).collect();
            let mut outputs = vec![0.0; 19 * 4];
            Inference::new(&shape).forward(&parameters, &inputs, &mut outputs);
            let device = burn::backend::ndarray::NdArrayDevice::Cpu;
            let network = Network::<NdArray<f32>>::new(&shape, &parameters, &device);
            let expected = numbers(network.forward(matrix(inputs, 19, &device)));
            for (output, expected) in outputs.iter().zip(&expected) {
                assert!((output - expected).abs() < 1e-5, "{output} is not {expected}");
            }
        }
    }
}
