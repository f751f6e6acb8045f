//! The learner on the CPU: explicit forward and backward passes over preallocated buffers.

mod buffer;
#[cfg(target_arch = "x86_64")]
mod dot;
mod emulated;
mod fma;
mod gemm;
mod kernels;
mod network;
mod optimizer;
mod pair;
mod pair_gemm;
mod pass;
mod peak;
mod portable;
mod product;
mod slice;
#[cfg(test)]
mod tests;
mod threads;
mod unpaired;

use super::engine::{Engine, Losses, NotFinite};
use super::simd::Simd;
use super::state::LearnerState;
use crate::batch::Batch;
use crate::config::{AgentConfig, TargetEvery};
use gemm::Gemm;
use network::Network;
use optimizer::Move;
use pair_gemm::PairGemm;
use pass::Machine;
use slice::{Job, Slice, Sums};
use threads::{Threads, for_each};

#[doc(hidden)]
pub use peak::gemm_peak;

/// Rows of a slice from which on there are more slices.
const SLICE_ROWS: usize = 512;
/// Rows from which a second slice pays for its share of the gradients.
const PAIR_ROWS: usize = 128;
/// Slices at most, for the memory of their gradients.
const SLICES: usize = 16;

/// Trains without an autodiff graph and, after the first update, without allocating.
///
/// Called on a thread of a rayon pool it uses that pool, and otherwise the caller's thread alone.
/// A batch is cut in slices by its size alone, and their gradients are added in a fixed order:
/// the results are the same bits for any number of threads.
#[derive(Debug)]
pub struct FusedEngine {
    config: AgentConfig,
    machine: Machine,
    actor: Network,
    critics: Vec<Network>,
    updates: u64,
    slices: Vec<Slice>,
}

impl FusedEngine {
    /// An engine that continues from `state`.
    pub fn from_state(config: &AgentConfig, state: LearnerState) -> Self {
        Self::on(Simd::chosen_or_fastest(), config, state)
    }

    fn on(simd: Simd, config: &AgentConfig, state: LearnerState) -> Self {
        let LearnerState { actor, critics, updates } = state;
        let inputs = actor.shape.inputs;
        Self {
            config: config.clone(),
            machine: Machine { simd, gemm: Gemm::new(simd), pair_gemm: PairGemm::new(simd) },
            actor: Network::new(actor, &(0..0), config.precision, simd),
            critics: critics
                .into_iter()
                .map(|critic| {
                    let actions = inputs..critic.shape.inputs;
                    Network::new(critic, &actions, config.precision, simd)
                })
                .collect(),
            updates,
            slices: Vec::new(),
        }
    }

    /// Of one critic's loss in the last update, in the layout of its shape.
    #[cfg(test)]
    pub(crate) fn critic_gradient(&self, index: usize) -> Vec<f32> {
        summed(self.slices.iter().map(|slice| &*slice.critic_gradients[index]))
    }

    /// Of the actor's loss when it last moved, in the layout of its shape.
    #[cfg(test)]
    pub(crate) fn actor_gradient(&self) -> Vec<f32> {
        summed(self.slices.iter().map(|slice| &*slice.actor_gradient))
    }

    /// Cuts `rows` rows into slices, unless they already are.
    fn cut(&mut self, rows: usize) {
        if self.slices.last().is_some_and(|slice| slice.rows.end == rows) {
            return;
        }
        let count = rows.div_ceil(SLICE_ROWS).max(rows.div_ceil(PAIR_ROWS).min(2)).min(SLICES);
        self.slices = (0..count)
            .map(|index| {
                let rows = rows * index / count..rows * (index + 1) / count;
                Slice::new(rows, &self.actor, &self.critics)
            })
            .collect();
    }
}

/// The first place where the gradients of the last pass are not finite.
fn check(slices: &[Slice], actor: &Network, critics: &[Network]) -> Result<(), NotFinite> {
    let Some(slice) = slices.iter().find(|slice| !slice.finite) else { return Ok(()) };
    let of_critics = critics.iter().zip(&slice.critic_gradients).enumerate();
    let mut found = of_critics.filter_map(|(index, (critic, gradient))| {
        NotFinite::find(&format!("critic {}", index + 1), &critic.shape, gradient)
    });
    let of_actor = || NotFinite::find("the actor", &actor.shape, &slice.actor_gradient);
    found.next().or_else(of_actor).map_or(Ok(()), Err)
}

impl Engine for FusedEngine {
    fn update(&mut self, batch: &Batch, noise: &[f32]) -> Result<Losses, NotFinite> {
        self.cut(batch.rows());
        let threads = Threads::current();
        let Self { config, machine, actor, critics, updates, slices } = self;
        let machine = *machine;
        let actor_moves = (*updates + 1).is_multiple_of(config.policy_delay);
        let targets_move = actor_moves && config.target_every == TargetEvery::Update;
        let target_rate = targets_move.then_some(config.target_rate);

        // targets   y from the target networks, slice by slice
        // critics   forward and backward slice by slice, then Adam on the slices' sum
        // actor     every `policy_delay` updates: through the first critic, then the same way
        // targets   move in the same pass as Adam
        let job = Job { machine, config, actor, critics, batch, noise };
        for_each(threads, slices, &|_, slice| slice.critics(job));
        check(slices, actor, critics)?;

        let how = Move { learning_rate: config.critic_learning_rate, target_rate, threads };
        for_each(threads, critics, &|index, critic| {
            critic.step(machine, how, slices.iter().map(|slice| &*slice.critic_gradients[index]));
        });

        if actor_moves {
            let job = Job { machine, config, actor, critics, batch, noise };
            for_each(threads, slices, &|_, slice| slice.actor(job));
            check(slices, actor, critics)?;

            let how = Move { learning_rate: config.actor_learning_rate, target_rate, threads };
            actor.step(machine, how, slices.iter().map(|slice| &*slice.actor_gradient));
        }
        *updates += 1;

        let sums = slices.iter().map(|slice| slice.sums).fold(Sums::NONE, Sums::plus);
        let rows = batch.rows() as f64;
        Ok(Losses {
            critic: (sums.squared_errors / rows) as f32,
            actor: actor_moves.then(|| {
                let numbers = rows * batch.action_dim as f64;
                let action_penalty = f64::from(config.action_l2) * sums.squared_actions / numbers;
                let imitation_error =
                    f64::from(config.imitation) * sums.squared_distances / numbers;
                (action_penalty + imitation_error - sums.q_of_actor / rows) as f32
            }),
            q_mean: (sums.q / rows) as f32,
            q_min: sums.q_min,
            q_max: sums.q_max,
            critic_gradient: critics.iter().map(|critic| critic.squared_norm).sum::<f64>().sqrt()
                as f32,
            actor_gradient: actor_moves.then(|| actor.squared_norm.sqrt() as f32),
        })
    }

    fn move_targets(&mut self) {
        for network in self.critics.iter_mut().chain([&mut self.actor]) {
            network.move_target(self.machine, self.config.target_rate);
        }
    }

    fn actor(&self) -> Vec<f32> {
        self.actor.online.flat.to_vec()
    }

    fn target_actor(&self) -> Vec<f32> {
        self.actor.target.flat.to_vec()
    }

    fn critic(&self) -> Vec<f32> {
        self.critics[0].online.flat.to_vec()
    }

    fn state(&self) -> LearnerState {
        LearnerState {
            actor: self.actor.trained(),
            critics: self.critics.iter().map(Network::trained).collect(),
            updates: self.updates,
        }
    }
}

#[cfg(test)]
fn summed<'a>(gradients: impl Iterator<Item = &'a [f32]>) -> Vec<f32> {
    let mut sum = Vec::new();
    for gradient in gradients {
        sum.resize(gradient.len(), 0.0);
        kernels::add(&mut sum, gradient);
    }
    sum
}
