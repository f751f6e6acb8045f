//! The part of an update that one thread does on its own rows.

use super::buffer::{Buffer, padded};
use super::network::Network;
use super::pass::{Deltas, Machine, Rows, Trace};
use crate::agent::config::AgentConfig;
use crate::batch::Batch;
use std::ops::Range;

/// What every slice reads during an update.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) machine: Machine,
    pub(super) config: &'a AgentConfig,
    pub(super) actor: &'a Network,
    pub(super) critics: &'a [Network],
    pub(super) batch: &'a Batch,
    /// Standard normal draws, `[rows, action]`.
    pub(super) noise: &'a [f32],
}

/// Rows of the batch and the memory to work on them.
#[derive(Debug)]
pub(super) struct Slice {
    /// Which rows of the batch.
    pub(super) rows: Range<usize>,
    actor_trace: Trace,
    critic_trace: Trace,
    deltas: Deltas,
    /// `[rows, input + action]`.
    critic_input: Buffer,
    /// Of the critic's output, `[rows, padded(action)]`.
    action_gradient: Buffer,
    /// Bellman targets, `[rows]`.
    targets: Buffer,
    /// Of the actor's loss over these rows, in the layout of the actor's shape.
    pub(super) actor_gradient: Buffer,
    /// Of each critic's loss over these rows, in the layout of the critics' shape.
    pub(super) critic_gradients: Vec<Buffer>,
    pub(super) sums: Sums,
    /// Whether the gradients of the last pass are numbers.
    pub(super) finite: bool,
}

/// Sums over a slice's rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    /// Of squared Bellman errors, of all critics.
    pub(super) squared_errors: f64,
    /// Of the first critic.
    pub(super) q: f64,
    pub(super) q_min: f32,
    pub(super) q_max: f32,
    /// Of the first critic at the actor's actions.
    pub(super) q_of_actor: f64,
    /// Of the actor's actions.
    pub(super) squared_actions: f64,
}

impl Sums {
    pub(super) const NONE: Self = Self {
        squared_errors: 0.0,
        q: 0.0,
        q_min: f32::INFINITY,
        q_max: f32::NEG_INFINITY,
        q_of_actor: 0.0,
        squared_actions: 0.0,
    };

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            squared_errors: self.squared_errors + other.squared_errors,
            q: self.q + other.q,
            q_min: self.q_min.min(other.q_min),
            q_max: self.q_max.max(other.q_max),
            q_of_actor: self.q_of_actor + other.q_of_actor,
            squared_actions: self.squared_actions + other.squared_actions,
        }
    }
}

impl Slice {
    pub(super) fn new(rows: Range<usize>, actor: &Network, critics: &[Network]) -> Self {
        let count = rows.len();
        let critic = &critics[0];
        let action = actor.shape.outputs;
        Self {
            actor_trace: Trace::new(&actor.layers, count),
            critic_trace: Trace::new(&critic.layers, count),
            deltas: Deltas::new(actor.layers.iter().chain(&critic.layers), count),
            critic_input: Buffer::zeros(count * critic.shape.inputs),
            action_gradient: Buffer::zeros(count * padded(action)),
            targets: Buffer::zeros(count),
            actor_gradient: Buffer::zeros(actor.online.flat.len()),
            critic_gradients: critics
                .iter()
                .map(|critic| Buffer::zeros(critic.online.flat.len()))
                .collect(),
            sums: Sums::NONE,
            finite: true,
            rows,
        }
    }

    /// Bellman targets, then the gradient of every critic.
    pub(super) fn critics(&mut self, job: Job<'_>) {
        self.find_targets(job);
        let Job { machine, batch, critics, .. } = job;
        let (rows, action) = (self.rows.len(), batch.action);
        let actions = batch.actions[self.rows.start * action..].chunks_exact(action);
        let state = self.states(&batch.inputs, batch.input);
        for (to, action) in fill_states(&mut self.critic_input, state, action).zip(actions) {
            to.copy_from_slice(action);
        }
        let input = Rows { data: &self.critic_input, stride: batch.input + action };
        self.sums = Sums::NONE;
        self.finite = true;
        for (index, (critic, gradient)) in
            critics.iter().zip(&mut self.critic_gradients).enumerate()
        {
            critic.forward(machine, &critic.online, input, rows, &mut self.critic_trace);
            let values = self.critic_trace.output().iter().step_by(padded(1));
            let deltas = self.deltas.output_mut().iter_mut().step_by(padded(1));
            for ((q, delta), target) in values.zip(deltas).zip(&*self.targets) {
                let error = q - target;
                *delta = 2.0 * error / batch.rows() as f32;
                self.sums.squared_errors += f64::from(error).powi(2);
                if index == 0 {
                    self.sums.q += f64::from(*q);
                    self.sums.q_min = self.sums.q_min.min(*q);
                    self.sums.q_max = self.sums.q_max.max(*q);
                }
            }
            critic.backward(machine, input, rows, &self.critic_trace, &mut self.deltas, gradient);
            self.finite &= machine.all_finite(gradient);
        }
    }

    /// y = clip(r + γ min(Q₁′, Q₂′)(s′, clip(π′(s′) + clip(σ ε, ±c), ±1)), [−1/(1−γ), 0])
    fn find_targets(&mut self, job: Job<'_>) {
        let Job { machine, config, actor, critics, batch, noise } = job;
        let (rows, action) = (self.rows.len(), batch.action);
        let next = self.states(&batch.next_inputs, batch.input);
        actor.forward(machine, &actor.target, next, rows, &mut self.actor_trace);
        let clip = config.target_noise_clip;
        let noise = noise[self.rows.start * action..].chunks_exact(action);
        let said = self.actor_trace.output().chunks_exact(padded(action)).zip(noise);
        for (row, (said, noise)) in fill_states(&mut self.critic_input, next, action).zip(said) {
            for ((to, said), noise) in row.iter_mut().zip(said).zip(noise) {
                let shake = (config.target_noise * noise).clamp(-clip, clip);
                *to = (said.tanh() + shake).clamp(-1.0, 1.0);
            }
        }

        let input = Rows { data: &self.critic_input, stride: batch.input + action };
        for (index, critic) in critics.iter().enumerate() {
            critic.forward(machine, &critic.target, input, rows, &mut self.critic_trace);
            let values = self.critic_trace.output().iter().step_by(padded(1));
            for (target, q) in self.targets.iter_mut().zip(values) {
                if index == 0 || *q < *target {
                    *target = *q;
                }
            }
        }
        let lowest = config.lowest_return();
        for (target, reward) in self.targets.iter_mut().zip(&batch.rewards[self.rows.clone()]) {
            *target = (reward + config.discount * *target).clamp(lowest, 0.0);
        }
    }

    /// The gradient of −mean Q₁(s, π(s)) + `action_l2` · mean π(s)² with respect to the actor.
    pub(super) fn actor(&mut self, job: Job<'_>) {
        let Job { machine, config, actor, critics, batch, .. } = job;
        let (rows, action) = (self.rows.len(), batch.action);
        let stride = padded(action);
        let state = self.states(&batch.inputs, batch.input);
        actor.forward(machine, &actor.online, state, rows, &mut self.actor_trace);
        let actions = self.actor_trace.output_mut().chunks_exact_mut(stride);
        let inputs = self.critic_input.chunks_exact_mut(batch.input + action);
        for (said, input) in actions.zip(inputs) {
            for (x, to) in said[..action].iter_mut().zip(&mut input[batch.input..]) {
                *x = x.tanh();
                *to = *x;
                self.sums.squared_actions += f64::from(*x).powi(2);
            }
        }

        let critic = &critics[0];
        let input = Rows { data: &self.critic_input, stride: batch.input + action };
        critic.forward(machine, &critic.online, input, rows, &mut self.critic_trace);
        let values = self.critic_trace.output().iter().step_by(padded(1));
        let deltas = self.deltas.output_mut().iter_mut().step_by(padded(1));
        for (q, delta) in values.zip(deltas).take(rows) {
            self.sums.q_of_actor += f64::from(*q);
            *delta = -1.0 / batch.rows() as f32;
        }
        critic.backward_to_input(
            machine,
            rows,
            &self.critic_trace,
            &mut self.deltas,
            &mut self.action_gradient,
        );

        let pull = 2.0 * config.action_l2 / (batch.rows() * action) as f32;
        let actions = self.actor_trace.output().chunks_exact(stride);
        let gradients = self.action_gradient.chunks_exact(stride).zip(actions);
        let deltas = self.deltas.output_mut().chunks_exact_mut(stride);
        for (delta, (gradient, actions)) in deltas.zip(gradients) {
            for ((delta, gradient), a) in delta.iter_mut().zip(gradient).zip(&actions[..action]) {
                *delta = (gradient + pull * a) * (1.0 - a * a);
            }
        }
        actor.backward(
            machine,
            state,
            rows,
            &self.actor_trace,
            &mut self.deltas,
            &mut self.actor_gradient,
        );
        self.finite &= machine.all_finite(&self.actor_gradient);
    }

    /// This slice's rows of `states`.
    fn states<'a>(&self, states: &'a [f32], width: usize) -> Rows<'a> {
        Rows { data: &states[self.rows.start * width..], stride: width }
    }
}

/// Writes `states` into the critics' input; the places of the actions, row by row.
fn fill_states<'a>(
    critic_input: &'a mut [f32],
    states: Rows<'a>,
    action: usize,
) -> impl Iterator<Item = &'a mut [f32]> {
    let width = states.stride;
    let rows = critic_input.chunks_exact_mut(width + action);
    rows.zip(states.data.chunks_exact(width)).map(move |(row, state)| {
        let (to, action) = row.split_at_mut(width);
        to.copy_from_slice(state);
        action
    })
}
