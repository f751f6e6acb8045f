//! The reference engine: Burn's modules, autodiff and Adam, one explicit graph per loss.

use super::engine::{BETA_1, BETA_2, EPSILON, Engine, Losses, NotFinite};
use super::network::{self, NORM_EPSILON, Shape};
use super::state::{LearnerState, Trained};
use crate::batch::Batch;
use crate::config::{AgentConfig, TargetEvery};
use burn::backend::{Autodiff, NdArray};
use burn::module::{Module, ModuleVisitor, Param};
use burn::nn::{LayerNorm, LayerNormConfig, Linear};
use burn::optim::{AdamConfig, AdamState, AdaptiveMomentumState, SimpleOptimizer as _};
use burn::tensor::activation::relu;
use burn::tensor::backend::{AutodiffBackend, Backend};
use burn::tensor::{Tensor, TensorData};
use std::ops::Range;

/// The engine on Burn's CPU backend.
pub type BurnEngine = AutodiffEngine<Autodiff<NdArray<f32>>>;

/// The engine on any of Burn's backends with autodiff.
pub struct AutodiffEngine<B: AutodiffBackend> {
    config: AgentConfig,
    actor: Learned<B::InnerBackend>,
    critics: Vec<Learned<B::InnerBackend>>,
    updates: u64,
    device: B::Device,
}

/// A network, its target and its optimizer as flat tensors with the layout of `shape`.
///
/// An update makes modules of them, which is cheap beside what it does with them.
struct Learned<B: Backend> {
    shape: Shape,
    online: Tensor<B, 1>,
    target: Tensor<B, 1>,
    adam: AdamState<B, 1>,
}

impl<B: Backend> Learned<B> {
    fn new(trained: Trained, device: &B::Device) -> Self {
        let Trained { shape, online, target, first_moment, second_moment, steps } = trained;
        let tensor = |values: Vec<f32>| Tensor::from_data(&*values, device);
        let moments = (tensor(first_moment), tensor(second_moment));
        Self {
            shape,
            online: tensor(online),
            target: tensor(target),
            adam: AdamState::new(AdaptiveMomentumState::new(steps as usize, moments.0, moments.1)),
        }
    }

    fn trained(&self) -> Trained {
        let AdaptiveMomentumState { time, moment_1, moment_2, .. } = self.adam.momentum.clone();
        Trained {
            shape: self.shape.clone(),
            online: numbers(self.online.clone()),
            target: numbers(self.target.clone()),
            first_moment: numbers(moment_1),
            second_moment: numbers(moment_2),
            steps: time as u64,
        }
    }

    /// One step of Burn's Adam, whose rule with this ε is PyTorch's:
    /// θ ← θ − rate · m̂ / (√v̂ + ε), both moments corrected for their start at zero.
    fn descend(&mut self, gradient: Tensor<B, 1>, learning_rate: f32) {
        let adam = AdamConfig::new().with_beta_1(BETA_1).with_beta_2(BETA_2).with_epsilon(EPSILON);
        let (online, state) = adam.build().step(
            learning_rate.into(),
            self.online.clone(),
            gradient,
            Some(self.adam.clone()),
        );
        self.online = online;
        self.adam = state.expect("Adam returns its moments");
    }

    /// θ′ ← θ′ + rate (θ − θ′).
    fn polyak_update(&mut self, rate: f32) {
        self.target = self.target.clone() + (self.online.clone() - self.target.clone()) * rate;
    }
}

impl<B: AutodiffBackend> AutodiffEngine<B> {
    /// An engine that continues from `state`, on the backend's default device.
    pub fn from_state(config: &AgentConfig, state: LearnerState) -> Self {
        let LearnerState { actor, critics, updates } = state;
        let device = B::Device::default();
        Self {
            config: config.clone(),
            actor: Learned::new(actor, &device),
            critics: critics.into_iter().map(|critic| Learned::new(critic, &device)).collect(),
            updates,
            device,
        }
    }

    /// The return that the critics are to predict, `[rows, 1]`.
    fn bellman(&self, batch: &Batch, noise: &[f32]) -> Tensor<B::InnerBackend, 2> {
        let rows = batch.rows();
        let (deviation, clip) = (self.config.target_noise, self.config.target_noise_clip);
        let target = |learned: &Learned<_>| Network::new(&learned.shape, &learned.target);
        let noise = noise.iter().map(|draw| (deviation * draw).clamp(-clip, clip)).collect();
        let noise = matrix(noise, rows, &self.device);
        let inputs = matrix(batch.next_inputs.clone(), rows, &self.device);
        let actions = target(&self.actor).forward(inputs.clone()).tanh();
        let inputs = Tensor::cat(vec![inputs, (actions + noise).clamp(-1.0, 1.0)], 1);
        let values = self.critics.iter().map(|critic| target(critic).forward(inputs.clone()));
        let value = values.reduce(Tensor::min_pair).expect("a learner has a critic");
        let repeated = batch.rewards.iter().map(|reward| self.config.repeated(*reward));
        let ended = batch.ended.iter().map(|ended| f32::from(u8::from(*ended)));
        let (repeated, ended) = (
            matrix(repeated.collect(), rows, &self.device),
            matrix(ended.collect(), rows, &self.device),
        );
        let value = value.mask_where(ended.equal_elem(1.0), repeated);
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
        let mut squared_norm = 0.0;
        let mut gradients = Vec::with_capacity(self.critics.len());
        for (index, critic) in self.critics.iter().enumerate() {
            let network = Network::trainable(critic);
            let values = network.forward(inputs.clone());
            if index == 0 {
                let values = numbers(values.clone().inner());
                losses.q_mean = values.iter().sum::<f32>() / rows as f32;
                losses.q_min = values.iter().copied().fold(f32::INFINITY, f32::min);
                losses.q_max = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            }
            let errors = values - returns.clone();
            let loss = (errors.clone() * errors).mean();
            let name = format!("critic {}", index + 1);
            let (gradient, square) = network.gradient(&loss, &name, &critic.shape)?;
            losses.critic += number(loss);
            squared_norm += square;
            gradients.push(gradient);
        }
        for (critic, gradient) in self.critics.iter_mut().zip(gradients) {
            critic.descend(gradient, self.config.critic_learning_rate);
        }
        losses.critic_gradient = squared_norm.sqrt();
        Ok(losses)
    }

    /// The actor's Adam step; gives its loss and the norm of its gradient.
    fn train_actor(&mut self, batch: &Batch) -> Result<(f32, f32), NotFinite> {
        let critic = Network::<B>::trainable(&self.critics[0]).no_grad();
        let network = Network::<B>::trainable(&self.actor);
        let inputs = matrix(batch.inputs.clone(), batch.rows(), &self.device);
        let actions = network.forward(inputs.clone()).tanh();
        let action_penalty = (actions.clone() * actions.clone()).mean();
        let simpler = matrix(batch.simpler_inputs.clone(), batch.rows(), &self.device);
        let imitates = batch.imitates.iter().map(|imitates| f32::from(u8::from(*imitates)));
        let imitates = matrix(imitates.collect(), batch.rows(), &self.device);
        let difference = (actions.clone() - network.forward(simpler).tanh().detach()) * imitates;
        let imitation_error = (difference.clone() * difference).mean();
        let value = critic.forward(Tensor::cat(vec![inputs, actions], 1)).mean();
        let loss = action_penalty * self.config.action_l2 + imitation_error * self.config.imitation
            - value;
        let (gradient, squared_norm) = network.gradient(&loss, "the actor", &self.actor.shape)?;
        self.actor.descend(gradient, self.config.actor_learning_rate);
        Ok((number(loss), squared_norm.sqrt()))
    }
}

impl<B: AutodiffBackend> Engine for AutodiffEngine<B> {
    fn update(&mut self, batch: &Batch, noise: &[f32]) -> Result<Losses, NotFinite> {
        let returns = self.bellman(batch, noise);
        let mut losses = self.train_critics(batch, returns)?;
        self.updates += 1;
        if self.updates.is_multiple_of(self.config.policy_delay) {
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
        for network in self.critics.iter_mut().chain([&mut self.actor]) {
            network.polyak_update(self.config.target_rate);
        }
    }

    fn actor(&self) -> Vec<f32> {
        numbers(self.actor.online.clone())
    }

    fn target_actor(&self) -> Vec<f32> {
        numbers(self.actor.target.clone())
    }

    fn critic(&self) -> Vec<f32> {
        numbers(self.critics[0].online.clone())
    }

    fn state(&self) -> LearnerState {
        LearnerState {
            actor: self.actor.trained(),
            critics: self.critics.iter().map(Learned::trained).collect(),
            updates: self.updates,
        }
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
    /// The network with these flat parameters.
    fn new(shape: &Shape, parameters: &Tensor<B, 1>) -> Self {
        let mut layers = shape.layers();
        let output = layers.pop().expect("a network has a layer");
        Self {
            hidden: layers.iter().map(|layer| Hidden::new(layer, parameters)).collect(),
            output: linear(&output, parameters),
        }
    }

    /// Outputs, `[rows, outputs]`, of inputs, `[rows, inputs]`.
    fn forward(&self, inputs: Tensor<B, 2>) -> Tensor<B, 2> {
        let features = self.hidden.iter().fold(inputs, |inputs, layer| layer.forward(inputs));
        self.output.forward(features)
    }
}

impl<B: AutodiffBackend> Network<B> {
    /// The trained network, whose parameters a loss can be differentiated by.
    fn trainable(learned: &Learned<B::InnerBackend>) -> Self {
        Self::new(&learned.shape, &Tensor::from_inner(learned.online.clone()))
    }

    /// The gradient of `loss` by the parameters, in the flat layout of `shape`, and the square of
    /// its norm.
    fn gradient(
        &self,
        loss: &Tensor<B, 1>,
        name: &str,
        shape: &Shape,
    ) -> Result<(Tensor<B::InnerBackend, 1>, f32), NotFinite> {
        let mut gather = Gather::<B> { gradients: loss.backward(), flat: Vec::new() };
        self.visit(&mut gather);
        let gradient = Tensor::cat(gather.flat, 0);
        let squared_norm = number((gradient.clone() * gradient.clone()).sum());
        // To copy the numbers of a shared tensor takes as long as a third of an update.
        if !squared_norm.is_finite()
            && let Some(error) = NotFinite::find(name, shape, &numbers(gradient.clone()))
        {
            return Err(error);
        }
        Ok((gradient, squared_norm))
    }
}

impl<B: Backend> Hidden<B> {
    fn new(layer: &network::Layer, parameters: &Tensor<B, 1>) -> Self {
        let norm = layer.norm.as_ref().map(|(scale, shift)| {
            let epsilon = f64::from(NORM_EPSILON);
            let mut norm = LayerNormConfig::new(layer.outputs)
                .with_epsilon(epsilon)
                .init(&parameters.device());
            norm.gamma = vector(parameters, scale);
            norm.beta = Some(vector(parameters, shift));
            norm
        });
        Self { linear: linear(layer, parameters), norm }
    }

    fn forward(&self, inputs: Tensor<B, 2>) -> Tensor<B, 2> {
        let sums = self.linear.forward(inputs);
        relu(match &self.norm {
            Some(norm) => norm.forward(sums),
            None => sums,
        })
    }
}

/// Collects the gradient of one parameter after the other.
struct Gather<B: AutodiffBackend> {
    gradients: B::Gradients,
    flat: Vec<Tensor<B::InnerBackend, 1>>,
}

impl<B: AutodiffBackend> ModuleVisitor<B> for Gather<B> {
    fn visit_float<const D: usize>(&mut self, parameter: &Param<Tensor<B, D>>) {
        let gradient = parameter.val().grad_remove(&mut self.gradients);
        self.flat.push(gradient.expect("the loss depends on every parameter").flatten(0, D - 1));
    }
}

fn linear<B: Backend>(layer: &network::Layer, parameters: &Tensor<B, 1>) -> Linear<B> {
    let weight = parameters.clone().slice(layer.weight.clone());
    Linear {
        weight: Param::from_tensor(weight.reshape([layer.inputs, layer.outputs])),
        bias: Some(vector(parameters, &layer.bias)),
    }
}

fn vector<B: Backend>(parameters: &Tensor<B, 1>, range: &Range<usize>) -> Param<Tensor<B, 1>> {
    Param::from_tensor(parameters.clone().slice(range.clone()))
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
    fn a_copy_of_the_state_continues_identically() {
        contract::a_copy_of_the_state_continues_identically(BurnEngine::from_state);
    }

    #[test]
    fn a_gradient_that_is_not_finite_is_located_and_moves_nothing() {
        contract::a_gradient_that_is_not_finite_is_located_and_moves_nothing(
            BurnEngine::from_state,
        );
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
            let network =
                Network::<NdArray<f32>>::new(&shape, &Tensor::from_data(&*parameters, &device));
            let expected = numbers(network.forward(matrix(inputs, 19, &device)));
            for (output, expected) in outputs.iter().zip(&expected) {
                assert!((output - expected).abs() < 1e-5, "{output} is not {expected}");
            }
        }
    }

    #[test]
    #[expect(clippy::disallowed_methods, reason = "compared with a tolerance")]
    fn five_steps_are_those_of_the_rule_in_f64() {
        let shape = Shape { inputs: 40, hidden: vec![], outputs: 1, layer_norm: false };
        let online: Vec<f32> = (0..41).map(|index| (index as f32).sin()).collect();
        let trained = Trained {
            shape,
            target: online.clone(),
            first_moment: vec![0.0; 41],
            second_moment: vec![0.0; 41],
            online,
            steps: 0,
        };
        let device = burn::backend::ndarray::NdArrayDevice::Cpu;
        let mut learned = Learned::<NdArray<f32>>::new(trained.clone(), &device);
        let mut expected: Vec<_> =
            trained.online.iter().map(|start| (f64::from(*start), 0.0, 0.0)).collect();
        for step in 1..=5 {
            // Over many orders of magnitude, to see where ε is added.
            let slope = |index: usize| {
                (step as f32 * index as f32).cos() * 0.1_f32.powf(index as f32 / 4.0)
            };
            let gradient: Vec<f32> = (0..41).map(slope).collect();
            learned.descend(Tensor::from_data(&*gradient, &device), 1e-2);
            for (index, (parameter, first, second)) in expected.iter_mut().enumerate() {
                let slope = f64::from(slope(index));
                *first = 0.9 * *first + 0.1 * slope;
                *second = 0.999 * *second + 0.001 * slope * slope;
                let mean = *first / (1.0 - 0.9_f64.powi(step));
                let square: f64 = *second / (1.0 - 0.999_f64.powi(step));
                *parameter -= 1e-2 * mean / (square.sqrt() + 1e-8);
            }
        }
        let trained = learned.trained();
        assert_eq!(trained.steps, 5);
        for (online, (expected, ..)) in trained.online.iter().zip(expected) {
            assert!((f64::from(*online) - expected).abs() < 1e-6, "{online} is not {expected}");
        }
    }
}
