//! How much arithmetic an update is, and how fast this machine could do it.

use super::buffer::{Buffer, LINE};
use super::gemm::Gemm;
use super::product::{Left, Product};
use super::simd::Simd;
use crate::config::AgentConfig;
use std::time::{Duration, Instant};

/// Floating-point operations in the matrix products of one update, as a mean over the policy delay.
///
/// With A and C the weights of the actor and of one critic, A₀ and C₀ those of their first layers
/// and Cₐ the part of C₀ that actions meet, each row takes
///
/// ```text
/// targets   2 A + 2 C · critics
/// critics   (2 C  +  2 C + 2 (C − C₀)) · critics
/// actor     (2 A + 2 C  +  2 (C − C₀ + Cₐ)  +  2 A + 2 (A − A₀)) / policy_delay
/// ```
pub fn flops(config: &AgentConfig, rows: usize, input: usize, action: usize) -> f64 {
    let weights = |inputs: usize, outputs: usize| {
        let widths = [&[inputs], &*config.hidden, &[outputs]].concat();
        let layers = widths.windows(2).map(|pair| (pair[0] * pair[1]) as f64);
        (layers.clone().sum::<f64>(), layers.clone().take(1).sum::<f64>())
    };
    let (actor, actor_first) = weights(input, action);
    let (critic, critic_first) = weights(input + action, 1);
    let critic_actions = critic_first * action as f64 / (input + action) as f64;

    let critics = config.critics as f64;
    let targets_update = 2.0 * actor + 2.0 * critic * critics;
    let critics_update = (6.0 * critic - 2.0 * critic_first) * critics;
    let actor_update =
        6.0 * actor - 2.0 * actor_first + 4.0 * critic - 2.0 * critic_first + 2.0 * critic_actions;
    rows as f64 * (targets_update + critics_update + actor_update / config.policy_delay as f64)
}

/// Floating-point operations per second of the engine's best product of `[rows, width]` and
/// `[width, width]`, on one thread with everything in its caches: the roof of an update.
///
/// Takes a tenth of a second.
pub fn gemm_peak(rows: usize, width: usize) -> f64 {
    const PATIENCE: Duration = Duration::from_millis(100);
    // One product is over before a clock speed can change.
    const PRODUCTS: usize = 16;
    let gemm = Gemm::new(Simd::detect());
    let width = width.next_multiple_of(LINE);
    // Zeros would take less power than a network's numbers.
    let numbers = |count| (0..count).map(|index| (index % 29) as f32 - 14.0).collect::<Vec<_>>();
    let left = Buffer::from(&*numbers(rows * width));
    let right = Buffer::from(&*numbers(width * width));
    let mut out = Buffer::zeros(rows * width);
    let start = Instant::now();
    let mut best = Duration::MAX;
    while start.elapsed() < PATIENCE {
        let products_start = Instant::now();
        for _ in 0..PRODUCTS {
            gemm.multiply(Product {
                left: Left::rows(&left, width),
                right: &right,
                right_stride: width,
                out: &mut out,
                out_stride: width,
                rows,
                depth: width,
                columns: width,
                accumulate: false,
            });
        }
        best = best.min(products_start.elapsed() / PRODUCTS as u32);
    }
    2.0 * (rows * width * width) as f64 / best.as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{EngineKind, Init, TargetEvery};

    #[test]
    fn an_update_of_the_paper_s_size_is_eight_hundred_megaflops() {
        let config = AgentConfig {
            engine: EngineKind::Fused,
            hidden: vec![256; 3],
            init: Init::Xavier,
            critics: 2,
            critic_layer_norm: false,
            policy_delay: 2,
            target_noise: 0.2,
            target_noise_clip: 0.5,
            discount: 0.98,
            action_l2: 1.0,
            imitation: 1.0,
            actor_learning_rate: 1e-3,
            critic_learning_rate: 1e-3,
            target_rate: 0.05,
            target_every: TargetEvery::Update,
        };
        assert_eq!(flops(&config, 1, 31, 4).round() as u64, 3_173_632);
    }

    #[test]
    fn the_peak_is_above_a_toy_s() {
        assert!(gemm_peak(256, 256) > 1e8);
    }
}
