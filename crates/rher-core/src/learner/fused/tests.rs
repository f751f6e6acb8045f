#![expect(clippy::disallowed_methods, reason = "compared with a tolerance")]

use super::{FusedEngine, Simd};
use crate::batch::Batch;
use crate::config::{AgentConfig, Init, Precision, TargetEvery};
use crate::learner::contract;
use crate::learner::engine::{BETA_1, BETA_2, EPSILON, Engine as _, Losses};
use crate::learner::network::{NORM_EPSILON, Shape};
use crate::learner::state::{LearnerState, Trained};
use crate::normal::StandardNormal;
use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

const INPUT: usize = 7;
const ACTION: usize = 3;

fn td3() -> AgentConfig {
    AgentConfig {
        hidden: vec![13, 9],
        target_noise_clip: 0.3,
        discount: 0.9,
        action_l2: 0.5,
        imitation: 0.8,
        critic_learning_rate: 2e-3,
        target_rate: 0.1,
        ..AgentConfig::td3()
    }
}

/// Every switch at least once on each side.
fn variants() -> Vec<AgentConfig> {
    vec![
        td3(),
        AgentConfig {
            init: Init::Xavier,
            critics: 1,
            policy_delay: 1,
            target_noise: 0.0,
            action_l2: 0.0,
            imitation: 0.0,
            target_every: TargetEvery::Episode,
            ..td3()
        },
        AgentConfig { critic_layer_norm: true, ..td3() },
        AgentConfig { hidden: vec![48, 16], policy_delay: 1, ..td3() },
        AgentConfig { hidden: vec![], critic_layer_norm: true, policy_delay: 1, ..td3() },
    ]
}

fn normals(count: usize, rng: &mut impl Rng) -> Vec<f32> {
    (0..count).map(|_| rng.sample(StandardNormal)).collect()
}

fn draw_batch(rows: usize, rng: &mut impl Rng) -> Batch {
    Batch {
        inputs: normals(rows * INPUT, rng),
        actions: (0..rows * ACTION).map(|_| rng.random_range(-1.0..1.0)).collect(),
        rewards: (0..rows).map(|_| -f32::from(rng.random_bool(0.7))).collect(),
        ended: (0..rows).map(|_| rng.random_bool(0.3)).collect(),
        next_inputs: normals(rows * INPUT, rng),
        imitates: (0..rows).map(|_| rng.random()).collect(),
        simpler_inputs: normals(rows * INPUT, rng),
        input_dim: INPUT,
        action_dim: ACTION,
    }
}

/// A learner whose targets and biases are not what a fresh one starts with.
fn draw_state(config: &AgentConfig, rng: &mut impl Rng) -> LearnerState {
    let mut state = LearnerState::new(config, INPUT, ACTION, rng);
    for trained in state.critics.iter_mut().chain([&mut state.actor]) {
        for x in trained.online.iter_mut().chain(&mut trained.target) {
            *x += rng.random_range(-0.1..0.1);
        }
    }
    state
}

/// The network's outputs for rows of inputs, in double precision and one number at a time.
fn reference(shape: &Shape, parameters: &[f64], inputs: &[f64]) -> Vec<f64> {
    let mut rows = inputs.to_vec();
    let layers = shape.layers();
    for (index, layer) in layers.iter().enumerate() {
        let (weight, bias) = (&parameters[layer.weight.clone()], &parameters[layer.bias.clone()]);
        let mut next = Vec::new();
        for row in rows.chunks_exact(layer.inputs) {
            let mut outputs: Vec<f64> = (0..layer.outputs)
                .map(|out| {
                    let products =
                        row.iter().enumerate().map(|(k, x)| x * weight[k * layer.outputs + out]);
                    bias[out] + products.sum::<f64>()
                })
                .collect();
            if let Some((scale, shift)) = &layer.norm {
                let width = outputs.len() as f64;
                let mean = outputs.iter().sum::<f64>() / width;
                let variance = outputs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / width;
                let deviation = (variance + f64::from(NORM_EPSILON)).sqrt();
                for (out, x) in outputs.iter_mut().enumerate() {
                    *x = (*x - mean) / deviation * parameters[scale.start + out]
                        + parameters[shift.start + out];
                }
            }
            if index + 1 < layers.len() {
                outputs = outputs.into_iter().map(|x| x.max(0.0)).collect();
            }
            next.extend(outputs);
        }
        rows = next;
    }
    rows
}

fn doubles(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(f64::from).collect()
}

fn side_by_side(states: &[f32], actions: &[f64]) -> Vec<f64> {
    states
        .chunks_exact(INPUT)
        .zip(actions.chunks_exact(ACTION))
        .flat_map(|(state, action)| doubles(state).into_iter().chain(action.iter().copied()))
        .collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

fn bellman_targets(
    config: &AgentConfig,
    state: &LearnerState,
    batch: &Batch,
    noise: &[f32],
) -> Vec<f64> {
    let outputs =
        reference(&state.actor.shape, &doubles(&state.actor.target), &doubles(&batch.next_inputs));
    let actions: Vec<f64> = outputs
        .iter()
        .zip(noise)
        .map(|(output, draw)| {
            let clip = f64::from(config.target_noise_clip);
            let noise = (f64::from(config.target_noise) * f64::from(*draw)).clamp(-clip, clip);
            (output.tanh() + noise).clamp(-1.0, 1.0)
        })
        .collect();
    let inputs = side_by_side(&batch.next_inputs, &actions);
    let values: Vec<Vec<f64>> = state
        .critics
        .iter()
        .map(|critic| reference(&critic.shape, &doubles(&critic.target), &inputs))
        .collect();
    (0..batch.rows())
        .map(|row| {
            let (reward, discount) = (f64::from(batch.rewards[row]), f64::from(config.discount));
            let least = values.iter().map(|q| q[row]).fold(f64::INFINITY, f64::min);
            let after = if batch.ended[row] { reward / (1.0 - discount) } else { least };
            (reward + discount * after).clamp(f64::from(config.lowest_return()), 0.0)
        })
        .collect()
}

fn critic_loss(shape: &Shape, parameters: &[f64], batch: &Batch, targets: &[f64]) -> f64 {
    let inputs = side_by_side(&batch.inputs, &doubles(&batch.actions));
    let values = reference(shape, parameters, &inputs);
    mean(values.iter().zip(targets).map(|(q, y)| (q - y).powi(2)))
}

fn actor_loss(
    config: &AgentConfig,
    shape: &Shape,
    parameters: &[f64],
    critic: &Trained,
    batch: &Batch,
    simpler: &[f64],
) -> f64 {
    let outputs = reference(shape, parameters, &doubles(&batch.inputs));
    let actions: Vec<f64> = outputs.into_iter().map(f64::tanh).collect();
    let inputs = side_by_side(&batch.inputs, &actions);
    let values = reference(&critic.shape, &doubles(&critic.online), &inputs);
    let mean_square = mean(actions.iter().map(|a| a.powi(2)));
    let distances = actions.iter().zip(simpler).enumerate().map(|(index, (a, simpler))| {
        if batch.imitates[index / ACTION] { (a - simpler).powi(2) } else { 0.0 }
    });
    f64::from(config.action_l2) * mean_square + f64::from(config.imitation) * mean(distances)
        - mean(values.into_iter())
}

/// Central differences.
fn gradient_of(parameters: &[f32], loss: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    const STEP: f64 = 1e-7;
    let mut parameters = doubles(parameters);
    (0..parameters.len())
        .map(|index| {
            let here = parameters[index];
            parameters[index] = here + STEP;
            let above = loss(&parameters);
            parameters[index] = here - STEP;
            let below = loss(&parameters);
            parameters[index] = here;
            (above - below) / (2.0 * STEP)
        })
        .collect()
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| x.powi(2)).sum::<f64>().sqrt()
}

/// Every tensor by itself, so that no small one hides behind a large one.
fn assert_tensors_close(shape: &Shape, found: &[f32], expected: &[f64], tolerance: f64) {
    for tensor in shape.tensors() {
        let (found, expected) =
            (doubles(&found[tensor.range.clone()]), &expected[tensor.range.clone()]);
        let error = norm(found.iter().zip(expected).map(|(x, y)| x - y));
        let size = norm(expected.iter().copied());
        assert!(
            error <= tolerance * size + 1e-6,
            "{}: {error} of {size}\n{found:?}\n{expected:?}",
            tensor.name
        );
    }
}

fn assert_close(found: f32, expected: f64) {
    let found = f64::from(found);
    assert!((found - expected).abs() <= 1e-5 * expected.abs().max(1.0), "{found} is no {expected}");
}

#[test]
fn gradients_are_those_of_a_plain_reference() {
    for (seed, config) in variants().iter().enumerate() {
        for rows in [1, 5, 37, 300] {
            let mut rng = ChaCha8Rng::seed_from_u64(seed as u64);
            let before = draw_state(config, &mut rng);
            let mut engine = FusedEngine::from_state(config, before.clone());
            let batch = draw_batch(rows, &mut rng);
            let noise = normals(rows * ACTION, &mut rng);
            // The other parity of a delayed actor.
            engine.updates = config.policy_delay - 1;
            let losses = engine.update(&batch, &noise).expect("finite");
            let after = engine.state();

            let targets = bellman_targets(config, &before, &batch, &noise);
            let mut critics_loss = 0.0;
            for (index, critic) in before.critics.iter().enumerate() {
                let loss = |p: &[f64]| critic_loss(&critic.shape, p, &batch, &targets);
                critics_loss += loss(&doubles(&critic.online));
                let expected = gradient_of(&critic.online, loss);
                let found = engine.critic_gradient(index);
                assert_tensors_close(&critic.shape, &found, &expected, 1e-4);
            }
            assert_close(losses.critic, critics_loss);

            let shape = &before.actor.shape;
            let actor = doubles(&before.actor.online);
            let simpler = reference(shape, &actor, &doubles(&batch.simpler_inputs));
            let simpler: Vec<f64> = simpler.into_iter().map(f64::tanh).collect();
            let critic = &after.critics[0];
            let loss = |p: &[f64]| actor_loss(config, shape, p, critic, &batch, &simpler);
            let expected = gradient_of(&before.actor.online, loss);
            assert_tensors_close(shape, &engine.actor_gradient(), &expected, 1e-4);
            assert_close(losses.actor.unwrap(), loss(&doubles(&before.actor.online)));
            assert_close(losses.actor_gradient.unwrap(), norm(expected.into_iter()));
        }
    }
}

/// One Adam step and one step of the target, in double precision.
fn assert_stepped(before: &Trained, after: &Trained, gradient: &[f32], rates: (f32, Option<f32>)) {
    assert_eq!(after.steps, before.steps + 1);
    let (learning_rate, target_rate) = rates;
    let steps = after.steps as f64;
    for (index, g) in gradient.iter().copied().map(f64::from).enumerate() {
        let decay = |old: f32, new: f64, beta: f32| {
            let beta = f64::from(beta);
            f64::from(old) * beta + (1.0 - beta) * new
        };
        let m = decay(before.first_moment[index], g, BETA_1);
        let v = decay(before.second_moment[index], g * g, BETA_2);
        assert!((f64::from(after.first_moment[index]) - m).abs() <= 1e-5 * m.abs() + 1e-9);
        assert!((f64::from(after.second_moment[index]) - v).abs() <= 1e-4 * v.abs() + 1e-12);
        let m = m / (1.0 - f64::from(BETA_1).powf(steps));
        let v = v / (1.0 - f64::from(BETA_2).powf(steps));
        let step = f64::from(learning_rate) * m / (v.sqrt() + f64::from(EPSILON));
        let online = f64::from(before.online[index]) - step;
        assert_close(after.online[index], online);
        let target = f64::from(before.target[index]);
        let rate = f64::from(target_rate.unwrap_or(0.0));
        assert_close(after.target[index], target + rate * (online - target));
    }
}

#[test]
fn parameters_and_targets_move_as_adam_and_the_settings_say() {
    for (seed, config) in variants().iter().enumerate() {
        let mut rng = ChaCha8Rng::seed_from_u64(seed as u64);
        let mut before = draw_state(config, &mut rng);
        let mut engine = FusedEngine::from_state(config, before.clone());
        for update in 1..=4 {
            let batch = draw_batch(150, &mut rng);
            let losses = engine.update(&batch, &normals(150 * ACTION, &mut rng)).expect("finite");
            let after = engine.state();
            assert_eq!(after.updates, update);
            let actor_moves = update % config.policy_delay == 0;
            let targets_move = actor_moves && config.target_every == TargetEvery::Update;
            let target_rate = targets_move.then_some(config.target_rate);
            for index in 0..config.critics {
                let (before, after) = (&before.critics[index], &after.critics[index]);
                let rates = (config.critic_learning_rate, target_rate);
                assert_stepped(before, after, &engine.critic_gradient(index), rates);
            }
            assert_eq!(losses.actor.is_some(), actor_moves);
            if actor_moves {
                let rates = (config.actor_learning_rate, target_rate);
                assert_stepped(&before.actor, &after.actor, &engine.actor_gradient(), rates);
            } else {
                assert_eq!(before.actor, after.actor);
            }
            before = after;
        }
        engine.move_targets();
        for (before, after) in before.critics.iter().zip(engine.state().critics) {
            for ((old, new), online) in before.target.iter().zip(after.target).zip(after.online) {
                let rate = f64::from(config.target_rate);
                assert_close(new, f64::from(*old) + rate * f64::from(online - old));
            }
        }
    }
}

fn train(engine: &mut FusedEngine, rows: usize, updates: usize) -> (LearnerState, Losses) {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut losses = Losses::default();
    for _ in 0..updates {
        let batch = draw_batch(rows, &mut rng);
        losses = engine.update(&batch, &normals(rows * ACTION, &mut rng)).expect("finite");
    }
    (engine.state(), losses)
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let config = AgentConfig { hidden: vec![256, 256], critic_layer_norm: true, ..td3() };
    let state = draw_state(&config, &mut ChaCha8Rng::seed_from_u64(1));
    let cases =
        [200, 700].into_iter().flat_map(|rows| [(rows, Precision::F32), (rows, Precision::Bf16)]);
    for (rows, precision) in cases {
        let config = AgentConfig { precision, ..config.clone() };
        let mut alone = FusedEngine::from_state(&config, state.clone());
        let expected = train(&mut alone, rows, 4);
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut engine = FusedEngine::from_state(&config, state.clone());
            assert_eq!(pool.install(|| train(&mut engine, rows, 4)), expected);
        }
    }
}

#[test]
fn every_set_of_instructions_learns_the_same_bits() {
    let wide = AgentConfig { hidden: vec![100, 64], ..td3() };
    for (config, rows, updates) in variants()
        .into_iter()
        .map(|config| (config, 50, 200))
        .chain([(wide.clone(), 300, 20), (AgentConfig { critic_layer_norm: true, ..wide }, 7, 200)])
    {
        let state = draw_state(&config, &mut ChaCha8Rng::seed_from_u64(2));
        let after = |simd| {
            let (state, losses) =
                train(&mut FusedEngine::on(simd, &config, state.clone()), rows, updates);
            // As bits, because 0 equals −0.
            let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let of = |trained: &Trained| {
                let Trained { online, target, first_moment, second_moment, .. } = trained;
                [online, target, first_moment, second_moment].map(|numbers| bits(numbers))
            };
            let critics = state.critics.iter().map(of).collect::<Vec<_>>();
            (of(&state.actor), critics, losses)
        };
        let [fastest, others @ ..] = &*Simd::every() else { unreachable!("there is always one") };
        let expected = after(*fastest);
        for simd in others {
            assert!(after(*simd) == expected, "{} is not {}", simd.name(), fastest.name());
        }
    }
}

#[test]
fn bf16_learns_the_same_bits_with_every_set_of_instructions() {
    let wide = AgentConfig { hidden: vec![96, 80], critic_layer_norm: true, ..td3() };
    for config in variants().into_iter().chain([wide]) {
        let config = AgentConfig { precision: Precision::Bf16, ..config };
        let state = draw_state(&config, &mut ChaCha8Rng::seed_from_u64(5));
        let mut best = FusedEngine::from_state(&config, state.clone());
        let expected = train(&mut best, 41, 200);
        for simd in Simd::every().into_iter().filter(|it| !matches!(it.arch(), pulp::Arch::Scalar))
        {
            let mut engine = FusedEngine::on(simd, &config, state.clone());
            let found = train(&mut engine, 41, 200);
            assert!(found == expected, "{simd:?}, {config:?}");
        }
    }
}

#[test]
fn bf16_gradients_are_near_those_of_f32() {
    for config in variants() {
        let state = draw_state(&config, &mut ChaCha8Rng::seed_from_u64(6));
        let mut exact = FusedEngine::from_state(&config, state.clone());
        let config = AgentConfig { precision: Precision::Bf16, ..config };
        let mut rounded = FusedEngine::from_state(&config, state);
        train(&mut exact, 300, 1);
        train(&mut rounded, 300, 1);
        for index in 0..config.critics {
            let expected = doubles(&exact.critic_gradient(index));
            let found = doubles(&rounded.critic_gradient(index));
            // Rounding decides for some rows whether a unit is active, and adds up where terms
            // cancel. A product of the wrong matrices would be off by its whole size.
            let error = norm(found.iter().zip(&expected).map(|(x, y)| x - y));
            let size = norm(expected.into_iter());
            assert!(error <= 0.1 * size, "{error} of {size}: {config:?}");
        }
    }
}

#[test]
fn a_saved_state_continues_with_the_same_bits() {
    let config = td3();
    let mut engine =
        FusedEngine::from_state(&config, draw_state(&config, &mut ChaCha8Rng::seed_from_u64(3)));
    let (saved, _) = train(&mut engine, 64, 3);
    let mut restored = FusedEngine::from_state(&config, saved);
    assert_eq!(train(&mut engine, 64, 3), train(&mut restored, 64, 3));
}

#[test]
fn gradients_are_slopes_of_the_losses() {
    contract::gradients_are_slopes_of_the_losses(FusedEngine::from_state);
}

#[test]
fn a_copy_of_the_state_continues_identically() {
    contract::a_copy_of_the_state_continues_identically(FusedEngine::from_state);
}

#[test]
fn values_are_the_known_returns() {
    contract::values_are_the_known_returns(FusedEngine::from_state);
}

#[test]
fn the_actor_finds_the_rewarded_action() {
    contract::the_actor_finds_the_rewarded_action(FusedEngine::from_state);
}

#[test]
fn a_gradient_that_is_not_finite_is_located_and_moves_nothing() {
    contract::a_gradient_that_is_not_finite_is_located_and_moves_nothing(FusedEngine::from_state);
}

#[test]
fn a_batch_of_another_size_may_follow() {
    let config = td3();
    let state = draw_state(&config, &mut ChaCha8Rng::seed_from_u64(4));
    let mut engine = FusedEngine::from_state(&config, state.clone());
    train(&mut engine, 300, 1);
    train(&mut engine, 20, 1);
}
