//! The fused engine against autodiff, update by update.

use super::burn::BurnEngine;
use super::config::{AgentConfig, Init, TargetEvery};
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

/// TD3 and DDPG, then each switch of TD3 on its other side, and other depths.
fn configs() -> Vec<AgentConfig> {
    let of =
        |preset: Preset| AgentConfig { hidden: vec![13, 9], ..preset.config("agreement", 1).agent };
    let td3 = || of(Preset::Fast);
    vec![
        td3(),
        of(Preset::Paper),
        AgentConfig { critic_layer_norm: true, ..td3() },
        AgentConfig { critics: 1, ..td3() },
        AgentConfig { policy_delay: 1, ..td3() },
        AgentConfig { target_noise: 0.0, ..td3() },
        AgentConfig { action_l2: 0.0, ..td3() },
        AgentConfig { init: Init::FanIn, ..td3() },
        AgentConfig { target_every: TargetEvery::Episode, ..td3() },
        AgentConfig { hidden: vec![], ..td3() },
        AgentConfig { hidden: vec![1], critic_layer_norm: true, ..td3() },
        AgentConfig { hidden: vec![32, 17, 16, 3], ..td3() },
    ]
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

/// The same learner, whose first moments will be a tenth of the next gradients.
fn without_momentum(state: &LearnerState) -> LearnerState {
    let mut state = state.clone();
    for trained in state.critics.iter_mut().chain([&mut state.actor]) {
        trained.first_moment.fill(0.0);
    }
    state
}

/// Every tensor of a network: parameters, target and moments.
fn assert_alike(network: &str, autodiff: &Trained, fused: &Trained) {
    let pairs = [
        ("online", &autodiff.online, &fused.online),
        ("target", &autodiff.target, &fused.target),
        ("first moment", &autodiff.first_moment, &fused.first_moment),
        ("second moment", &autodiff.second_moment, &fused.second_moment),
    ];
    for (kind, expected, found) in pairs {
        for tensor in autodiff.shape.tensors() {
            let (expected, found) = (&expected[tensor.range.clone()], &found[tensor.range]);
            let error = norm(expected.iter().zip(found).map(|(expected, found)| expected - found));
            let limit = (TOLERANCE * norm(expected.iter().copied())).max(1e-10);
            assert!(error <= limit, "{kind} {} of the {network}: {error} > {limit}", tensor.name);
        }
    }
}

fn norm(values: impl Iterator<Item = f32>) -> f64 {
    values.map(|x| f64::from(x).powi(2)).sum::<f64>().sqrt()
}

/// One update of both engines from `state`, and the state that autodiff comes to.
fn assert_same_update(
    config: &AgentConfig,
    state: LearnerState,
    batch: &Batch,
    noise: &[f32],
) -> LearnerState {
    let mut autodiff = BurnEngine::from_state(config, state.clone());
    let mut fused = FusedEngine::from_state(config, state);
    autodiff.update(batch, noise).expect("finite");
    fused.update(batch, noise).expect("finite");
    if config.target_every == TargetEvery::Episode {
        autodiff.move_targets();
        fused.move_targets();
    }
    let (expected, found) = (autodiff.state(), fused.state());
    assert_alike("actor", &expected.actor, &found.actor);
    for (critic, other) in expected.critics.iter().zip(&found.critics) {
        assert_alike("critic", critic, other);
    }
    expected
}

#[test]
fn both_engines_make_the_same_updates() {
    for config in configs() {
        for rows in [1, 37, 300] {
            let mut rng = ChaCha8Rng::seed_from_u64(rows as u64);
            let mut state = LearnerState::new(&config, INPUT, ACTION, &mut rng);
            for _ in 0..UPDATES {
                let (batch, noise) = draw(rows, &mut rng);
                // The Bellman error of a single row can be as small as its rounding.
                if rows > 1 {
                    assert_same_update(&config, without_momentum(&state), &batch, &noise);
                }
                state = assert_same_update(&config, state, &batch, &noise);
            }
        }
    }
}
