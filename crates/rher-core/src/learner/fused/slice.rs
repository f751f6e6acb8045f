//! The part of an update that one thread does on its own rows.

use super::buffer::{Buffer, padded};
use super::network::Network;
use super::pass::{Deltas, Gradient, Machine, Rows, Trace};
use crate::batch::Batch;
use crate::config::AgentConfig;
use libm::tanhf;
use std::ops::Range;

/// Rows whose activations stay in a core's own cache, with the weights that they meet.
const CHUNK_ROWS: usize = 256;

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
    /// The actions that are imitated, `[rows of a chunk, action]`; undefined in other rows.
    simpler_actions: Buffer,
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
    /// Of the actor's actions and those that it imitates.
    pub(super) squared_distances: f64,
}

impl Sums {
    pub(super) const NONE: Self = Self {
        squared_errors: 0.0,
        q: 0.0,
        q_min: f32::INFINITY,
        q_max: f32::NEG_INFINITY,
        q_of_actor: 0.0,
        squared_actions: 0.0,
        squared_distances: 0.0,
    };

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            squared_errors: self.squared_errors + other.squared_errors,
            q: self.q + other.q,
            q_min: self.q_min.min(other.q_min),
            q_max: self.q_max.max(other.q_max),
            q_of_actor: self.q_of_actor + other.q_of_actor,
            squared_actions: self.squared_actions + other.squared_actions,
            squared_distances: self.squared_distances + other.squared_distances,
        }
    }
}

impl Slice {
    pub(super) fn new(rows: Range<usize>, actor: &Network, critics: &[Network]) -> Self {
        let count = rows.len();
        let chunk = chunks(count).map(|chunk| chunk.len()).max().unwrap_or(0);
        let critic = &critics[0];
        let action = actor.shape.outputs;
        Self {
            actor_trace: Trace::new(&actor.layers, chunk),
            critic_trace: Trace::new(&critic.layers, chunk),
            deltas: Deltas::new(actor.layers.iter().chain(&critic.layers), chunk),
            critic_input: Buffer::zeros(count * critic.shape.inputs),
            action_gradient: Buffer::zeros(chunk * padded(action)),
            simpler_actions: Buffer::zeros(chunk * action),
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
    ///
    /// Network by network, and chunk by chunk for each: a network's weights stay in the core's
    /// cache from one chunk to the next.
    pub(super) fn critics(&mut self, job: Job<'_>) {
        self.find_targets(job);
        let Job { machine, batch, critics, .. } = job;
        let (count, action) = (self.rows.len(), batch.action_dim);
        let width = batch.input_dim + action;
        let actions = batch.actions[self.rows.start * action..].chunks_exact(action);
        let state = self.states(&batch.inputs, batch.input_dim);
        for (to, action) in fill_states(&mut self.critic_input, state, action).zip(actions) {
            to.copy_from_slice(action);
        }
        self.sums = Sums::NONE;
        self.finite = true;
        for (index, (critic, gradient)) in
            critics.iter().zip(&mut self.critic_gradients).enumerate()
        {
            for chunk in chunks(count) {
                let rows = chunk.len();
                let input = Rows { data: &self.critic_input[chunk.start * width..], stride: width };
                critic.forward(machine, &critic.online, input, rows, &mut self.critic_trace);
                let values = self.critic_trace.output();
                let deltas = self.deltas.output_mut();
                for ((q, delta), target) in
                    values.iter().zip(deltas).zip(&self.targets[chunk.clone()])
                {
                    let error = q - target;
                    *delta = 2.0 * error / batch.rows() as f32;
                    self.sums.squared_errors += square(error);
                    if index == 0 {
                        self.sums.q += f64::from(*q);
                        self.sums.q_min = self.sums.q_min.min(*q);
                        self.sums.q_max = self.sums.q_max.max(*q);
                    }
                }
                let trace = &self.critic_trace;
                let gradient = Gradient { values: gradient, accumulate: chunk.start > 0 };
                critic.backward(machine, input, rows, trace, &mut self.deltas, gradient);
            }
            self.finite &= machine.all_finite(gradient);
        }
    }

    /// y = clip(r + γ min(Q₁′, Q₂′)(s′, clip(π′(s′) + clip(σ ε, ±c), ±1)), [−1/(1−γ), 0]), with
    /// r/(1−γ) in place of the minimum where the episode ended.
    fn find_targets(&mut self, job: Job<'_>) {
        let Job { machine, config, actor, critics, batch, noise } = job;
        let (count, action) = (self.rows.len(), batch.action_dim);
        let width = batch.input_dim + action;
        let next = self.states(&batch.next_inputs, batch.input_dim);
        let clip = config.target_noise_clip;
        let noise = &noise[self.rows.start * action..];
        let mut inputs = fill_states(&mut self.critic_input, next, action);
        for chunk in chunks(count) {
            let states =
                Rows { data: &next.data[chunk.start * next.stride..], stride: next.stride };
            actor.forward(machine, &actor.target, states, chunk.len(), &mut self.actor_trace);
            let outputs = self.actor_trace.output().chunks_exact(actor.output_stride());
            let noise = noise[chunk.start * action..].chunks_exact(action);
            for ((output, noise), row) in outputs.zip(noise).zip(inputs.by_ref().take(chunk.len()))
            {
                for ((to, output), draw) in row.iter_mut().zip(output).zip(noise) {
                    let noise = (config.target_noise * draw).clamp(-clip, clip);
                    *to = (tanhf(*output) + noise).clamp(-1.0, 1.0);
                }
            }
        }
        drop(inputs);

        for (index, critic) in critics.iter().enumerate() {
            for chunk in chunks(count) {
                let input = Rows { data: &self.critic_input[chunk.start * width..], stride: width };
                let trace = &mut self.critic_trace;
                critic.forward(machine, &critic.target, input, chunk.len(), trace);
                for (target, q) in self.targets[chunk].iter_mut().zip(trace.output()) {
                    if index == 0 || *q < *target {
                        *target = *q;
                    }
                }
            }
        }
        let lowest = config.lowest_return();
        let ended = &batch.ended[self.rows.clone()];
        let rewards = batch.rewards[self.rows.clone()].iter().zip(ended);
        for (target, (reward, ended)) in self.targets.iter_mut().zip(rewards) {
            let after = if *ended { config.repeated(*reward) } else { *target };
            *target = (reward + config.discount * after).clamp(lowest, 0.0);
        }
    }

    /// The gradient of the actor's loss, −mean Q₁(s, π(s)) + `action_l2` · mean π(s)² +
    /// `imitation` · mean m (π(s) − π(s₋))², with π(s₋) constant.
    pub(super) fn actor(&mut self, job: Job<'_>) {
        for chunk in chunks(self.rows.len()) {
            self.actor_of(chunk, job);
        }
        self.finite &= job.machine.all_finite(&self.actor_gradient);
    }

    fn actor_of(&mut self, chunk: Range<usize>, job: Job<'_>) {
        let Job { machine, config, actor, critics, batch, .. } = job;
        let (rows, action) = (chunk.len(), batch.action_dim);
        let width = batch.input_dim + action;
        let stride = actor.output_stride();
        let imitates = &batch.imitates[self.rows.clone()][chunk.clone()];
        let imitates = (config.imitation > 0.0 && imitates.contains(&true)).then_some(imitates);
        if imitates.is_some() {
            let states = self.states(&batch.simpler_inputs, batch.input_dim);
            let states = Rows { data: &states.data[chunk.start * states.stride..], ..states };
            actor.forward(machine, &actor.online, states, rows, &mut self.actor_trace);
            let outputs = self.actor_trace.output().chunks_exact(stride);
            for (to, output) in self.simpler_actions.chunks_exact_mut(action).zip(outputs) {
                for (to, output) in to.iter_mut().zip(output) {
                    *to = tanhf(*output);
                }
            }
        }
        let states = self.states(&batch.inputs, batch.input_dim);
        let states = Rows { data: &states.data[chunk.start * states.stride..], ..states };
        actor.forward(machine, &actor.online, states, rows, &mut self.actor_trace);
        let actions = self.actor_trace.output_mut().chunks_exact_mut(stride);
        let input = &mut self.critic_input[chunk.start * width..chunk.end * width];
        for (output, input) in actions.zip(input.chunks_exact_mut(width)) {
            for (x, to) in output[..action].iter_mut().zip(&mut input[batch.input_dim..]) {
                *x = tanhf(*x);
                *to = *x;
                self.sums.squared_actions += square(*x);
            }
        }

        let critic = &critics[0];
        let input = Rows { data: input, stride: width };
        critic.forward(machine, &critic.online, input, rows, &mut self.critic_trace);
        let values = self.critic_trace.output().iter().take(rows);
        for (q, delta) in values.zip(self.deltas.output_mut()) {
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

        let weight = 2.0 * config.action_l2 / (batch.rows() * action) as f32;
        let actions = self.actor_trace.output().chunks_exact(stride);
        let gradients = self.action_gradient.chunks_exact(padded(action)).zip(actions);
        let deltas = self.deltas.output_mut().chunks_exact_mut(stride);
        for (delta, (gradient, actions)) in deltas.zip(gradients) {
            for ((delta, gradient), a) in delta.iter_mut().zip(gradient).zip(&actions[..action]) {
                *delta = gradient + weight * a;
            }
        }
        if let Some(imitates) = imitates {
            let weight = 2.0 * config.imitation / (batch.rows() * action) as f32;
            let actions = self.actor_trace.output().chunks_exact(stride);
            let deltas = self.deltas.output_mut().chunks_exact_mut(stride);
            let simpler = self.simpler_actions.chunks_exact(action);
            let rows = deltas.zip(actions).zip(simpler).zip(imitates);
            for (((delta, actions), simpler), _) in rows.filter(|(_, imitates)| **imitates) {
                for ((delta, a), simpler) in delta.iter_mut().zip(actions).zip(simpler) {
                    *delta += weight * (a - simpler);
                    self.sums.squared_distances += square(a - simpler);
                }
            }
        }
        let actions = self.actor_trace.output().chunks_exact(stride);
        for (delta, actions) in self.deltas.output_mut().chunks_exact_mut(stride).zip(actions) {
            for (delta, a) in delta.iter_mut().zip(&actions[..action]) {
                *delta *= 1.0 - a * a;
            }
        }
        let gradient = Gradient { values: &mut self.actor_gradient, accumulate: chunk.start > 0 };
        actor.backward(machine, states, rows, &self.actor_trace, &mut self.deltas, gradient);
    }

    /// This slice's rows of `states`.
    fn states<'a>(&self, states: &'a [f32], width: usize) -> Rows<'a> {
        Rows { data: &states[self.rows.start * width..], stride: width }
    }
}

/// Rows that are worked on together, evenly cut.
fn chunks(rows: usize) -> impl Iterator<Item = Range<usize>> {
    let count = rows.div_ceil(CHUNK_ROWS);
    (0..count).map(move |index| rows * index / count..rows * (index + 1) / count)
}

fn square(x: f32) -> f64 {
    f64::from(x) * f64::from(x)
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
