//! How much arithmetic updates are.

use rher_core::EnvSpec;
use rher_core::config::{AgentConfig, BatchMode, Method, TrainConfig};
use rher_core::input::InputEncoder;

/// Floating-point operations in the matrix products of one update, as a mean over the policy delay.
///
/// With A and C the weights of the actor and of one critic, A₀ and C₀ those of their first layers
/// and Cₐ the part of C₀ that multiplies actions, each row takes
///
/// ```text
/// targets   2 A + 2 C · critics
/// critics   (2 C  +  2 C + 2 (C − C₀)) · critics
/// actor     (2 A + 2 C  +  2 (C − C₀ + Cₐ)  +  2 A + 2 (A − A₀)) / policy_delay
/// ```
pub(crate) fn of_update(
    config: &AgentConfig,
    rows: usize,
    input_dim: usize,
    action_dim: usize,
) -> f64 {
    let weights = |inputs: usize, outputs: usize| {
        let widths = [&[inputs], &*config.hidden, &[outputs]].concat();
        let layers = widths.windows(2).map(|pair| (pair[0] * pair[1]) as f64);
        (layers.clone().sum::<f64>(), layers.clone().take(1).sum::<f64>())
    };
    let (actor, actor_first) = weights(input_dim, action_dim);
    let (critic, critic_first) = weights(input_dim + action_dim, 1);
    let critic_actions = critic_first * action_dim as f64 / (input_dim + action_dim) as f64;

    let critics = config.critics as f64;
    let targets_update = 2.0 * actor + 2.0 * critic * critics;
    let critics_update = (6.0 * critic - 2.0 * critic_first) * critics;
    let actor_update =
        6.0 * actor - 2.0 * actor_first + 4.0 * critic - 2.0 * critic_first + 2.0 * critic_actions;
    rows as f64 * (targets_update + critics_update + actor_update / config.policy_delay as f64)
}

/// The same for all `updates` of a run in environments like `spec`; without imitation, which is up
/// to a tenth more where there is any.
pub(crate) fn of_run<const N: usize>(config: &TrainConfig, spec: &EnvSpec<N>, updates: u64) -> f64 {
    let subtasks = match (config.replay.batch_mode, config.relay.method) {
        (BatchMode::Joint, Method::Rher) => spec.subtasks,
        (BatchMode::Separate, _) | (_, Method::Her) => 1,
    };
    let rows = subtasks * config.replay.batch_size;
    let input = InputEncoder::new(&config.relay, spec).width();
    updates as f64 * of_update(&config.agent, rows, input, spec.action_dim)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_update_with_the_paper_s_networks_is_three_megaflops_a_row() {
        let config = AgentConfig { hidden: vec![256; 3], ..AgentConfig::td3() };
        assert_eq!(of_update(&config, 1, 31, 4).round() as u64, 3_173_632);
    }
}
