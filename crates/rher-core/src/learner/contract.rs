//! What every engine must do: its gradients against differences of f64 losses, its values against
//! problems whose answer is known.
#![expect(clippy::disallowed_methods, reason = "compared with a tolerance")]

use super::engine::{BETA_1, Engine};
use super::infer::Inference;
use super::network::{NORM_EPSILON, Shape};
use super::state::{LearnerState, Trained};
use crate::batch::Batch;
use crate::config::{AgentConfig, TargetEvery};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Makes the engine under test.
pub(super) type Build<E> = fn(&AgentConfig, LearnerState) -> E;

const INPUT: usize = 3;
const ACTION: usize = 2;

fn td3() -> AgentConfig {
    AgentConfig {
        hidden: vec![5, 7],
        target_noise_clip: 0.3,
        discount: 0.5,
        action_l2: 0.7,
        imitation: 0.3,
        actor_learning_rate: 1e-2,
        critic_learning_rate: 1e-2,
        target_rate: 0.1,
        ..AgentConfig::td3()
    }
}

fn ddpg() -> AgentConfig {
    AgentConfig { critics: 1, policy_delay: 1, target_noise: 0.0, ..td3() }
}

/// Transitions at random, some with returns out of bounds, and noise.
fn transitions(rows: usize, rng: &mut ChaCha8Rng) -> (Batch, Vec<f32>) {
    let mut batch = Batch::zeros(rows, INPUT, ACTION);
    let inputs = batch.inputs.iter_mut().chain(&mut batch.next_inputs).chain(&mut batch.actions);
    inputs.for_each(|number| *number = rng.random_range(-1.0..1.0));
    batch.rewards.fill_with(|| rng.random_range(-3.0..1.0));
    let noise = (0..rows * ACTION).map(|_| rng.random_range(-2.0..2.0)).collect();
    batch.simpler_inputs.fill_with(|| rng.random_range(-1.0..1.0));
    batch.imitates.fill_with(|| rng.random());
    batch.ended.fill_with(|| rng.random_bool(0.3));
    (batch, noise)
}

/// A learner with targets away from the trained networks, and no parameter at rest.
fn learner(config: &AgentConfig, rng: &mut ChaCha8Rng) -> LearnerState {
    let mut state = LearnerState::new(config, INPUT, ACTION, rng);
    for trained in std::iter::once(&mut state.actor).chain(&mut state.critics) {
        for (online, target) in trained.online.iter_mut().zip(&mut trained.target) {
            *online += rng.random_range(-0.2..0.2);
            *target += rng.random_range(-0.8..0.8);
        }
    }
    state
}

pub(super) fn gradients_are_slopes_of_the_losses<E: Engine>(build: Build<E>) {
    for base in [td3(), ddpg()] {
        for critic_layer_norm in [false, true] {
            for target_every in [TargetEvery::Update, TargetEvery::Episode] {
                let action_l2 = if critic_layer_norm { 0.0 } else { base.action_l2 };
                let config =
                    AgentConfig { critic_layer_norm, action_l2, target_every, ..base.clone() };
                one_update_agrees(build, &config);
            }
        }
    }
}

fn one_update_agrees<E: Engine>(build: Build<E>, config: &AgentConfig) {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (batch, noise) = transitions(19, &mut rng);
    let mut engine = build(config, learner(config, &mut rng));
    for _ in 1..config.policy_delay {
        let actor = engine.state().actor;
        let losses = engine.update(&batch, &noise).expect("finite");
        assert_eq!((losses.actor, losses.actor_gradient), (None, None));
        assert_eq!(engine.state().actor, actor);
    }
    let before = engine.state();
    let losses = engine.update(&batch, &noise).expect("finite");
    let after = engine.state();
    assert_eq!(after.updates, config.policy_delay);

    let rows = rows(&batch);
    let returns = bellman(config, &before, &rows, &noise);
    let bounds = [f64::from(config.lowest_return()), 0.0];
    assert!(bounds.iter().all(|bound| returns.contains(bound)), "{returns:?} meet both bounds");
    assert!(returns.iter().any(|y| !bounds.contains(y)), "{returns:?} are not all at the bounds");

    let (mut loss, mut squares) = (0.0, 0.0);
    for (before, after) in before.critics.iter().zip(&after.critics) {
        let error = |parameters: &[f64]| {
            mean(rows.iter().zip(&returns).map(|(row, y)| {
                (value(&before.shape, parameters, &row.inputs, &row.actions) - y).powi(2)
            }))
        };
        loss += error(&doubles(&before.online));
        squares += slopes_agree(before, after, error);
    }
    close(losses.critic, loss);
    close(losses.critic_gradient, squares.sqrt());

    let critic = doubles(&before.critics[0].online);
    let values =
        rows.iter().map(|row| value(&before.critics[0].shape, &critic, &row.inputs, &row.actions));
    close(losses.q_mean, mean(values.clone()));
    close(losses.q_min, values.clone().fold(f64::INFINITY, f64::min));
    close(losses.q_max, values.fold(f64::NEG_INFINITY, f64::max));

    let critic = doubles(&after.critics[0].online);
    let error = |parameters: &[f64]| {
        mean(rows.iter().map(|row| {
            let actions = act(&before.actor.shape, parameters, &row.inputs);
            let action_penalty = mean(actions.iter().map(|action| action * action));
            let value = value(&after.critics[0].shape, &critic, &row.inputs, &actions);
            let imitation_error = row.simpler.as_ref().map_or(0.0, |simpler| {
                let simpler = act(&before.actor.shape, &doubles(&before.actor.online), simpler);
                mean(actions.iter().zip(simpler).map(|(action, other)| (action - other).powi(2)))
            });
            f64::from(config.action_l2) * action_penalty
                + f64::from(config.imitation) * imitation_error
                - value
        }))
    };
    let squares = slopes_agree(&before.actor, &after.actor, error);
    close(losses.actor.expect("the actor moved"), error(&doubles(&before.actor.online)));
    close(losses.actor_gradient.expect("the actor moved"), squares.sqrt());

    if config.target_every == TargetEvery::Episode {
        targets_moved(0.0, &before, &after);
        engine.move_targets();
    }
    targets_moved(config.target_rate, &before, &engine.state());
}

/// Compares the gradient that went into the first moment with differences of `loss`; gives its
/// squared norm.
fn slopes_agree(before: &Trained, after: &Trained, loss: impl Fn(&[f64]) -> f64) -> f64 {
    const STEP: f64 = 1e-6;
    assert_eq!(after.steps, before.steps + 1);
    let mut parameters = doubles(&before.online);
    let slopes: Vec<f64> = (0..parameters.len())
        .map(|index| {
            let middle = parameters[index];
            let mut at = |parameter| {
                parameters[index] = parameter;
                loss(&parameters)
            };
            let slope = (at(middle + STEP) - at(middle - STEP)) / (2.0 * STEP);
            at(middle);
            slope
        })
        .collect();
    for ((slope, before), after) in slopes.iter().zip(&before.first_moment).zip(&after.first_moment)
    {
        close((after - BETA_1 * before) / (1.0 - BETA_1), *slope);
    }
    slopes.iter().map(|slope| slope * slope).sum()
}

fn targets_moved(rate: f32, before: &LearnerState, after: &LearnerState) {
    let before = std::iter::once(&before.actor).chain(&before.critics);
    let after = std::iter::once(&after.actor).chain(&after.critics);
    for (before, after) in before.zip(after) {
        for ((old, new), online) in before.target.iter().zip(&after.target).zip(&after.online) {
            close(*new, f64::from(old + rate * (online - old)));
        }
    }
}

pub(super) fn a_copy_of_the_state_continues_identically<E: Engine>(build: Build<E>) {
    for config in [td3(), ddpg(), AgentConfig { critic_layer_norm: true, ..td3() }] {
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let start = learner(&config, &mut rng);
        let mut first = build(&config, start.clone());
        assert_eq!(first.state(), start);
        let mut update = |engines: &mut [&mut E]| {
            let (batch, noise) = transitions(33, &mut rng);
            let losses: Vec<_> =
                engines.iter_mut().map(|e| e.update(&batch, &noise).expect("finite")).collect();
            assert!(losses.iter().all(|each| *each == losses[0]));
        };
        (0..3).for_each(|_| update(&mut [&mut first]));
        let mut second = build(&config, first.state());
        (0..3).for_each(|_| update(&mut [&mut first, &mut second]));
        assert_eq!(first.state(), second.state());
        assert_eq!(first.actor(), second.state().actor.online);
        assert_ne!(first.state(), start);
    }
}

/// The mean value of the first critic after training on one batch in which `reward` is the rule,
/// and the first action that the actor takes.
fn trained<E: Engine>(build: Build<E>, reward: impl Fn(&[f32]) -> f32) -> (f32, f32) {
    let mut config = AgentConfig { hidden: vec![16, 16], action_l2: 0.0, ..td3() };
    config.target_noise = 0.02;
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut batch, noise) = transitions(64, &mut rng);
    batch.inputs.fill(0.5);
    batch.next_inputs.fill(0.5);
    batch.rewards = batch.actions.chunks(ACTION).map(reward).collect();
    let mut engine = build(&config, LearnerState::new(&config, INPUT, ACTION, &mut rng));
    for _ in 0..1500 {
        engine.update(&batch, &noise).expect("finite");
    }
    let mut actions = [0.0; ACTION];
    let shape = engine.state().actor.shape;
    Inference::new(&shape).act(&engine.actor(), &[0.5; INPUT], &mut actions);
    (engine.update(&batch, &noise).expect("finite").q_mean, actions[0])
}

pub(super) fn values_are_the_known_returns<E: Engine>(build: Build<E>) {
    let lowest = td3().lowest_return();
    let (never, _) = trained(build, |_| -1.0);
    assert!((never - lowest).abs() < 0.05, "{never} is not {lowest}");
    let (always, _) = trained(build, |_| 0.0);
    assert!(always.abs() < 0.05, "{always} is not 0");
}

pub(super) fn the_actor_finds_the_rewarded_action<E: Engine>(build: Build<E>) {
    let (_, action) = trained(build, |actions| -(actions[0] - 0.5).powi(2));
    assert!((action - 0.5).abs() < 0.1, "{action} is not 0.5");
}

pub(super) fn a_gradient_that_is_not_finite_is_located_and_moves_nothing<E: Engine>(
    build: Build<E>,
) {
    for config in [td3(), ddpg(), AgentConfig { critic_layer_norm: true, ..td3() }] {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        for nonsense in [f32::NAN, f32::INFINITY] {
            let start = learner(&config, &mut rng);
            let mut engine = build(&config, start.clone());
            let (mut batch, noise) = transitions(40, &mut rng);
            batch.rewards[17] = nonsense;
            if nonsense.is_infinite() {
                batch.rewards[17] = 0.0;
                batch.inputs[17] = nonsense;
            }
            let error = engine.update(&batch, &noise).expect_err("not finite");
            assert_eq!(error.network, "critic 1");
            assert_eq!(engine.state(), start);
        }

        let mut broken = learner(&config, &mut rng);
        broken.updates = config.policy_delay - 1;
        broken.actor.online[3] = f32::NAN;
        let (batch, noise) = transitions(40, &mut rng);
        let error = build(&config, broken).update(&batch, &noise).expect_err("not finite");
        assert_eq!(error.network, "the actor");
        assert!(error.tensor.starts_with("layers."), "{error}");
    }
}

struct Row {
    inputs: Vec<f64>,
    actions: Vec<f64>,
    reward: f64,
    ended: bool,
    next: Vec<f64>,
    simpler: Option<Vec<f64>>,
}

fn rows(batch: &Batch) -> Vec<Row> {
    (0..batch.rows())
        .map(|row| Row {
            inputs: doubles(&batch.inputs[row * INPUT..][..INPUT]),
            actions: doubles(&batch.actions[row * ACTION..][..ACTION]),
            reward: batch.rewards[row].into(),
            ended: batch.ended[row],
            next: doubles(&batch.next_inputs[row * INPUT..][..INPUT]),
            simpler: batch.imitates[row]
                .then(|| doubles(&batch.simpler_inputs[row * INPUT..][..INPUT])),
        })
        .collect()
}

fn bellman(config: &AgentConfig, state: &LearnerState, rows: &[Row], noise: &[f32]) -> Vec<f64> {
    let clip = f64::from(config.target_noise_clip);
    let discount = f64::from(config.discount);
    let one = |(row, noise): (&Row, &[f32])| {
        let mut actions = act(&state.actor.shape, &doubles(&state.actor.target), &row.next);
        for (action, draw) in actions.iter_mut().zip(noise) {
            let noise = f64::from(config.target_noise) * f64::from(*draw);
            *action = (*action + noise.clamp(-clip, clip)).clamp(-1.0, 1.0);
        }
        let values = state
            .critics
            .iter()
            .map(|critic| value(&critic.shape, &doubles(&critic.target), &row.next, &actions));
        let value = if row.ended {
            row.reward / (1.0 - discount)
        } else {
            values.fold(f64::INFINITY, f64::min)
        };
        (row.reward + discount * value).clamp(-1.0 / (1.0 - discount), 0.0)
    };
    rows.iter().zip(noise.chunks(ACTION)).map(one).collect()
}

/// A critic's value of an action.
fn value(shape: &Shape, parameters: &[f64], inputs: &[f64], actions: &[f64]) -> f64 {
    forward(shape, parameters, &[inputs, actions].concat())[0]
}

fn act(shape: &Shape, parameters: &[f64], inputs: &[f64]) -> Vec<f64> {
    forward(shape, parameters, inputs).into_iter().map(f64::tanh).collect()
}

fn forward(shape: &Shape, parameters: &[f64], inputs: &[f64]) -> Vec<f64> {
    let layers = shape.layers();
    let mut now = inputs.to_vec();
    for (index, layer) in layers.iter().enumerate() {
        let weights = &parameters[layer.weight.clone()];
        let mut next = parameters[layer.bias.clone()].to_vec();
        for (input, weights) in now.iter().zip(weights.chunks(layer.outputs)) {
            for (sum, weight) in next.iter_mut().zip(weights) {
                *sum += input * weight;
            }
        }
        if let Some((scale, shift)) = layer.norm.clone() {
            let center = mean(next.iter().copied());
            let variance = mean(next.iter().map(|x| (x - center).powi(2)));
            let spread = (variance + f64::from(NORM_EPSILON)).sqrt();
            let affine = parameters[scale].iter().zip(&parameters[shift]);
            for (x, (scale, shift)) in next.iter_mut().zip(affine) {
                *x = (*x - center) / spread * scale + shift;
            }
        }
        if index + 1 < layers.len() {
            for x in &mut next {
                *x = x.max(0.0);
            }
        }
        now = next;
    }
    now
}

fn doubles(numbers: &[f32]) -> Vec<f64> {
    numbers.iter().map(|number| f64::from(*number)).collect()
}

fn mean(numbers: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = numbers.len() as f64;
    numbers.sum::<f64>() / count
}

fn close(is: f32, should: f64) {
    let error = (f64::from(is) - should).abs();
    assert!(error < 1e-5 + 1e-4 * should.abs(), "{is} is not {should}");
}
