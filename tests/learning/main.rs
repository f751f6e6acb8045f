//! Learning where the answer is known.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![expect(clippy::float_cmp, reason = "what should be the same is the same to the last bit")]

mod probe;
#[path = "../core/toy.rs"]
mod toy;

use probe::Probe;
use rher_core::config::{Method, TrainConfig};
use rher_core::event::Metrics;
use rher_core::train::Trainer;
use std::sync::atomic::AtomicBool;
use toy::{Lines, Magnet, small};

fn probe(config: TrainConfig, target: f32) -> Metrics {
    let mut lines = Lines::default();
    let mut trainer = Trainer::new(config, vec![Probe::new(target)], 1).unwrap();
    trainer.run(None, &mut lines, &AtomicBool::new(false)).unwrap();
    lines.0.pop().unwrap()
}

/// Only what the task asks for, so that every value has one cause.
fn without_hindsight() -> TrainConfig {
    let mut config = small("probe", 1);
    config.relay.method = Method::Her;
    config.relay.hindsight = 0.0;
    config.agent.discount = 0.9;
    config.agent.target_rate = 0.1;
    config.env_steps = 500;
    config.evaluation.every_episodes = 50;
    config
}

#[test]
fn where_nothing_is_ever_reached_the_value_is_the_lowest_return() {
    let metrics = probe(without_hindsight(), 1.0);
    assert!((metrics.q_mean + 10.0).abs() < 0.5, "{}", metrics.q_mean);
    assert_eq!(metrics.single_reward, [None, Some(1.0)]);
    assert_eq!(metrics.success_final, 0.0);
}

#[test]
fn where_all_is_reached_at_once_the_value_is_zero() {
    let mut config = without_hindsight();
    config.exploration.noise = 0.0;
    config.exploration.random = 0.0;
    let metrics = probe(config, 0.0);
    assert!(metrics.q_mean.abs() < 0.5, "{}", metrics.q_mean);
    assert_eq!(metrics.success_final, 1.0);
}

#[test]
fn the_actor_finds_the_action_that_is_rewarded() {
    let mut config = without_hindsight();
    config.env_steps = 2_000;
    config.agent.action_l2 = 0.1;
    config.exploration.random = 0.5;
    let metrics = probe(config, 0.09);
    assert_eq!(metrics.success_final, 1.0);
    assert!(metrics.final_distance < 0.05, "{}", metrics.final_distance);
}

fn magnet(config: TrainConfig) -> Metrics {
    let mut lines = Lines::default();
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    trainer.run(None, &mut lines, &AtomicBool::new(false)).unwrap();
    lines.0.pop().unwrap()
}

#[test]
fn hindsight_and_the_relay_are_what_learns() {
    let mut config = small("magnet", 1);
    config.agent.hidden = vec![128, 128];
    config.agent.critics = 2;
    config.agent.policy_delay = 2;
    config.agent.target_noise = 0.2;
    config.agent.discount = 0.9;
    config.relay.reach_distance = 0.09;
    // The method alone: with these, plain hindsight solves a task as small as this one, too.
    config.relay.fine_scale = false;
    config.relay.redraw_met = 0.0;
    config.replay.focus = 0.0;
    config.agent.critic_layer_norm = false;
    config.env_steps = 500 * 25;
    config.evaluation.every_episodes = 500;
    // One seed is a matter of luck.
    let mut mean_rate = |method, hindsight| {
        config.relay.method = method;
        config.relay.hindsight = hindsight;
        let rate = |seed| magnet(TrainConfig { seed, ..config.clone() }).success_final;
        (1..=3).map(rate).sum::<f32>() / 3.0
    };
    let relay = mean_rate(Method::Rher, 0.8);
    let plain = mean_rate(Method::Her, 0.8);
    let none = mean_rate(Method::Her, 0.0);
    assert!(relay >= 0.5, "relay {relay}");
    assert!(plain <= relay - 0.1, "plain hindsight {plain}, relay {relay}");
    assert!(none <= 0.1, "no hindsight {none}");
}
