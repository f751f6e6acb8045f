//! Adam and the targets' Polyak update, in one pass over the parameters.

use super::kernels::{self, Step};
use super::network::Network;
use super::pass::Machine;
use super::threads::{Threads, join};
use crate::learner::engine::{BETA_1, BETA_2};

/// Parameters whose summed gradient stays in the nearest cache.
const BLOCK: usize = 2048;
/// Parameters that are worth another thread.
const SPAN: usize = 16 * BLOCK;

/// How one network moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Move {
    /// Adam's step size.
    pub(super) learning_rate: f32,
    /// Share of the way that the target moves, if it does.
    pub(super) target_rate: Option<f32>,
    /// The threads that share the work.
    pub(super) threads: Threads,
}

impl Network {
    /// One Adam step on the sum of the slices' gradients.
    pub(super) fn step<'a, G>(&mut self, machine: Machine, how: Move, gradients: G)
    where
        G: Iterator<Item = &'a [f32]> + Clone + Send + Sync,
    {
        self.steps += 1;
        let steps = self.steps as f64;
        let task = Task {
            machine,
            how,
            step: Step {
                rate: (f64::from(how.learning_rate) / (1.0 - libm::pow(f64::from(BETA_1), steps)))
                    as f32,
                inverse_root: (1.0 - libm::pow(f64::from(BETA_2), steps)).sqrt().recip() as f32,
            },
            gradients,
        };
        let span = Span {
            start: 0,
            online: &mut self.online.flat,
            target: &mut self.target.flat,
            first_moment: &mut self.first_moment,
            second_moment: &mut self.second_moment,
        };
        self.squared_norm = task.step(span);
        self.copy_online(machine.simd);
        if how.target_rate.is_some() {
            self.target.copy(&self.layers, machine.simd);
        }
    }

    /// Moves the target alone.
    pub(super) fn move_target(&mut self, machine: Machine, rate: f32) {
        let (target, online) = (&mut self.target.flat, &self.online.flat);
        machine.simd.run(
            #[inline(always)]
            || kernels::polyak_update(target, online, rate),
        );
        self.target.copy(&self.layers, machine.simd);
    }
}

struct Task<G> {
    machine: Machine,
    how: Move,
    step: Step,
    gradients: G,
}

/// Neighboring parameters and what belongs to them.
struct Span<'a> {
    start: usize,
    online: &'a mut [f32],
    target: &'a mut [f32],
    first_moment: &'a mut [f32],
    second_moment: &'a mut [f32],
}

impl Span<'_> {
    fn split_at(self, middle: usize) -> (Self, Self) {
        let (online, online_rest) = self.online.split_at_mut(middle);
        let (target, target_rest) = self.target.split_at_mut(middle);
        let (first_moment, first_rest) = self.first_moment.split_at_mut(middle);
        let (second_moment, second_rest) = self.second_moment.split_at_mut(middle);
        (
            Self { start: self.start, online, target, first_moment, second_moment },
            Self {
                start: self.start + middle,
                online: online_rest,
                target: target_rest,
                first_moment: first_rest,
                second_moment: second_rest,
            },
        )
    }
}

impl<'g, G> Task<G>
where
    G: Iterator<Item = &'g [f32]> + Clone + Send + Sync,
{
    /// Always cut at the same places, so that the norm does not depend on the threads.
    fn step(&self, mut span: Span<'_>) -> f64 {
        let length = span.online.len();
        if length > SPAN {
            let (left, right) = span.split_at((length / 2).next_multiple_of(BLOCK));
            let (left, right) = join(self.how.threads, || self.step(left), || self.step(right));
            return left + right;
        }
        let mut squared_norm = 0.0;
        while span.online.len() > BLOCK {
            let (block, rest) = span.split_at(BLOCK);
            squared_norm += self.step_block(block);
            span = rest;
        }
        squared_norm + self.step_block(span)
    }

    fn step_block(&self, block: Span<'_>) -> f64 {
        let Span { start, online, target, first_moment, second_moment } = block;
        let mut sum = [0.0; BLOCK];
        let sum = &mut sum[..online.len()];
        self.machine.simd.run(
            #[inline(always)]
            || {
                for gradient in self.gradients.clone() {
                    kernels::add(sum, &gradient[start..]);
                }
                kernels::adam(self.step, sum, online, first_moment, second_moment);
                if let Some(rate) = self.how.target_rate {
                    kernels::polyak_update(target, online, rate);
                }
                f64::from(kernels::sum(sum, |g| g * g))
            },
        )
    }
}
