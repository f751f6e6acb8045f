//! The fused engine against autodiff, update by update.
#![expect(clippy::disallowed_methods, reason = "compared with a tolerance")]

use super::burn::BurnEngine;
use super::engine::Engine as _;
use super::fused::FusedEngine;
use super::state::{LearnerState, Trained};
use crate::batch::Batch;
use crate::config::Preset;
use crate::config::{AgentConfig, Init, Precision, TargetEvery};
use crate::normal::StandardNormal;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

const INPUT: usize = 7;
const ACTION: usize = 3;
const UPDATES: usize = 100;
const TOLERANCE: f64 = 1e-4;
/// Of two updates in a hundred: a unit within rounding of 0 may be on for one engine alone.
const AT_A_KINK: f64 = 1e-2;
/// Share of a network's norm below which a tensor is what is left of larger terms.
const CANCELED: f64 = 0.02;

/// TD3 and DDPG, then each switch of TD3 on its other side, and other depths; in the precision that
/// both engines have.
fn configs() -> Vec<AgentConfig> {
    let of = |preset: Preset| AgentConfig {
        hidden: vec![13, 9],
        precision: Precision::F32,
        ..preset.config("agreement", 1).agent
    };
    let td3 = || of(Preset::Fast);
    vec![
        td3(),
        of(Preset::Paper),
        AgentConfig { critic_layer_norm: true, ..td3() },
        AgentConfig { critics: 1, ..td3() },
        AgentConfig { policy_delay: 1, ..td3() },
        AgentConfig { target_noise: 0.0, ..td3() },
        AgentConfig { action_l2: 0.0, ..td3() },
        AgentConfig { imitation: 0.0, ..td3() },
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
    batch.simpler_inputs.fill_with(|| rng.sample(StandardNormal));
    batch.imitates.fill_with(|| rng.random());
    batch.ended.fill_with(|| rng.random_bool(0.3));
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

/// The largest relative difference of any tensor: parameters, targets and moments.
///
/// It is relative to the tensor, or to the network when a tensor's terms cancel.
fn difference(autodiff: &Trained, fused: &Trained) -> f64 {
    let pairs = [
        (&autodiff.online, &fused.online),
        (&autodiff.target, &fused.target),
        (&autodiff.first_moment, &fused.first_moment),
        (&autodiff.second_moment, &fused.second_moment),
    ];
    let of_pair = |(expected, found): (&Vec<f32>, &Vec<f32>)| {
        let canceled = CANCELED * norm(expected.iter().copied());
        let tensors = autodiff.shape.tensors().into_iter().map(move |tensor| {
            let (expected, found) = (&expected[tensor.range.clone()], &found[tensor.range]);
            let error = norm(expected.iter().zip(found).map(|(expected, found)| expected - found));
            error / norm(expected.iter().copied()).max(canceled).max(1e-6)
        });
        tensors.fold(0.0, f64::max)
    };
    pairs.into_iter().map(of_pair).fold(0.0, f64::max)
}

fn norm(values: impl Iterator<Item = f32>) -> f64 {
    values.map(|x| f64::from(x).powi(2)).sum::<f64>().sqrt()
}

/// One update of both engines from `state`: what autodiff comes to, and how far the other is off.
fn update_both(
    config: &AgentConfig,
    state: LearnerState,
    batch: &Batch,
    noise: &[f32],
) -> (LearnerState, f64) {
    let mut autodiff = BurnEngine::from_state(config, state.clone());
    let mut fused = FusedEngine::from_state(config, state);
    autodiff.update(batch, noise).expect("finite");
    fused.update(batch, noise).expect("finite");
    if config.target_every == TargetEvery::Episode {
        autodiff.move_targets();
        fused.move_targets();
    }
    let (expected, found) = (autodiff.state(), fused.state());
    let critics = expected.critics.iter().zip(&found.critics);
    let networks = critics.chain([(&expected.actor, &found.actor)]);
    let worst = networks.map(|(expected, found)| difference(expected, found)).fold(0.0, f64::max);
    (expected, worst)
}

#[test]
fn both_engines_make_the_same_updates() {
    for config in configs() {
        for rows in [1, 37, 700] {
            let mut rng = ChaCha8Rng::seed_from_u64(rows as u64);
            let mut state = LearnerState::new(&config, INPUT, ACTION, &mut rng);
            let mut differences = Vec::new();
            for _ in 0..UPDATES {
                let (batch, noise) = draw(rows, &mut rng);
                // The Bellman error of a single row can be as small as its rounding.
                if rows > 1 {
                    let (_, worst) = update_both(&config, without_momentum(&state), &batch, &noise);
                    differences.push(worst);
                }
                let (next, worst) = update_both(&config, state, &batch, &noise);
                differences.push(worst);
                state = next;
            }
            differences.sort_by(f64::total_cmp);
            let case = format!("{rows} rows, {config:?}");
            let worst = differences[differences.len() - 1];
            assert!(worst <= AT_A_KINK, "{worst}: {case}");
            let most = differences[differences.len() - 1 - UPDATES / 50];
            assert!(most <= TOLERANCE, "{most}: {case}");
        }
    }
}
