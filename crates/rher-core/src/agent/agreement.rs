//! The fused engine against autodiff, update by update.

use super::burn::BurnEngine;
use super::config::{AgentConfig, TargetEvery};
use super::fused::FusedEngine;
use super::learner::{Engine as _, LearnerState, Trained};
use crate::batch::Batch;
use crate::config::Preset;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const INPUT: usize = 7;
const ACTION: usize = 3;
const UPDATES: usize = 100;
const TOLERANCE: f64 = 1e-4;

/// TD3 and DDPG, with and without layer normalisation, with both kinds of targets.
fn configs() -> [AgentConfig; 3] {
    let fast = Preset::Fast.config("agreement", 1).agent;
    let paper = Preset::Paper.config("agreement", 1).agent;
    let normalised = AgentConfig { critic_layer_norm: true, ..fast.clone() };
    [fast, paper, normalised].map(|config| AgentConfig { hidden: vec![13, 9], ..config })
}

fn draw(rows: usize, rng: &mut ChaCha8Rng) -> (Batch, Vec<f32>) {
    let mut batch = Batch::zeros(rows, INPUT, ACTION);
    batch.inputs.fill_with(|| rng.sample(StandardNormal));
    batch.next_inputs.fill_with(|| rng.sample(StandardNormal));
    batch.actions.fill_with(|| rng.random_range(-1.0..=1.0));
    batch.rewards.fill_with(|| if rng.random() { 0.0 } else { -1.0 });
    let noise = (0..rows * ACTION).map(|_| rng.sample(StandardNormal)).collect();
    (batch, noise)
}

/// Every tensor of a network, its target and both moments; the first moment is the gradient's.
fn assert_alike(network: &str, autodiff: &Trained, fused: &Trained) {
    let pairs = [
        ("online", &autodiff.online, &fused.online),
        ("target", &autodiff.target, &fused.target),
        ("first moment", &autodiff.first_moment, &fused.first_moment),
        ("second moment", &autodiff.second_moment, &fused.second_moment),
    ];
    for tensor in autodiff.shape.tensors() {
        for (kind, expected, found) in pairs {
            let pairs = expected[tensor.range.clone()].iter().zip(&found[tensor.range.clone()]);
            let (mut error, mut size) = (0.0, 0.0);
            for (expected, found) in pairs {
                error += f64::from(expected - found).powi(2);
                size += f64::from(*expected).powi(2);
            }
            let relative = (error / size.max(1e-20)).sqrt();
            assert!(relative <= TOLERANCE, "{kind} {} of the {network}: {relative}", tensor.name);
        }
    }
}

#[test]
fn both_engines_make_the_same_updates() {
    for config in configs() {
        for rows in [1, 37, 300] {
            let mut rng = ChaCha8Rng::seed_from_u64(rows as u64);
            let mut state = LearnerState::new(&config, INPUT, ACTION, &mut rng);
            for _ in 0..UPDATES {
                let (batch, noise) = draw(rows, &mut rng);
                let mut autodiff = BurnEngine::from_state(&config, state.clone());
                let mut fused = FusedEngine::from_state(&config, state);
                autodiff.update(&batch, &noise);
                fused.update(&batch, &noise);
                if config.target_every == TargetEvery::Episode {
                    autodiff.move_targets();
                    fused.move_targets();
                }
                state = autodiff.state();
                let other = fused.state();
                assert_alike("actor", &state.actor, &other.actor);
                for (critic, other) in state.critics.iter().zip(&other.critics) {
                    assert_alike("critic", critic, other);
                }
            }
        }
    }
}
