//! Ranges of the settings.

use super::{TrainConfig, VERSION};

/// A setting is outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` is {value}, expected {allowed}")]
pub struct ConfigError {
    /// Dotted name of the setting, as in `--set`.
    pub key: &'static str,
    /// What it is.
    pub value: String,
    /// What it may be.
    pub allowed: &'static str,
}

impl TrainConfig {
    /// Checks every range that the types do not.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let Self { version, task: _, preset: _, seed: _, env_steps, until, envs, .. } = self;
        let Self { relay, exploration, replay, agent, evaluation, .. } = self;
        if *version != VERSION {
            return Err(ConfigError {
                key: "version",
                value: version.to_string(),
                allowed: "1, the version of this program",
            });
        }
        at_least("env_steps", *env_steps, 1, "at least 1")?;
        share("until", *until)?;
        at_least("envs", *envs, 1, "at least 1")?;

        positive("relay.reach_distance", relay.reach_distance, true)?;
        positive("relay.tolerance", relay.tolerance, false)?;
        share("relay.tolerance", relay.tolerance)?;
        share("relay.hindsight", relay.hindsight)?;
        share("relay.mirror", relay.mirror)?;
        share("relay.exchange", relay.exchange)?;

        share("exploration.guide", exploration.guide)?;
        share("exploration.random", exploration.random)?;
        if exploration.guide + exploration.random > 1.0 + f32::EPSILON {
            return Err(ConfigError {
                key: "exploration.guide",
                value: exploration.guide.to_string(),
                allowed: "at most 1 − `exploration.random`",
            });
        }
        at_least("exploration.random_steps", exploration.random_steps, 1.0, "at least 1")?;
        positive("exploration.noise", exploration.noise, true)?;
        share("exploration.success_threshold", exploration.success_threshold)?;
        at_least("exploration.window", exploration.window, 1, "at least 1")?;

        at_least("replay.capacity", replay.capacity, 1, "at least 1")?;
        at_least("replay.batch_size", replay.batch_size, 1, "at least 1")?;
        share("replay.focus", replay.focus)?;
        at_least("replay.updates_per_episode", replay.updates_per_episode, 1, "at least 1")?;

        if agent.hidden.is_empty() || agent.hidden.contains(&0) {
            return Err(ConfigError {
                key: "agent.hidden",
                value: format!("{:?}", agent.hidden),
                allowed: "at least one layer, each at least 1 wide",
            });
        }
        if !matches!(agent.critics, 1 | 2) {
            return Err(ConfigError {
                key: "agent.critics",
                value: agent.critics.to_string(),
                allowed: "1 (DDPG) or 2 (TD3)",
            });
        }
        at_least("agent.policy_delay", agent.policy_delay, 1, "at least 1")?;
        positive("agent.target_noise", agent.target_noise, true)?;
        positive("agent.target_noise_clip", agent.target_noise_clip, true)?;
        if !(0.0..1.0).contains(&agent.discount) {
            return Err(ConfigError {
                key: "agent.discount",
                value: agent.discount.to_string(),
                allowed: "at least 0 and below 1",
            });
        }
        positive("agent.action_l2", agent.action_l2, true)?;
        positive("agent.imitation", agent.imitation, true)?;
        positive("agent.actor_learning_rate", agent.actor_learning_rate, false)?;
        positive("agent.critic_learning_rate", agent.critic_learning_rate, false)?;
        positive("agent.target_rate", agent.target_rate, false)?;
        share("agent.target_rate", agent.target_rate)?;

        let every = evaluation.every_episodes;
        at_least("evaluation.every_episodes", every, 1, "at least 1")?;
        at_least("evaluation.episodes", evaluation.episodes, 1, "at least 1")?;
        at_least("evaluation.subtask_episodes", evaluation.subtask_episodes, 1, "at least 1")
    }
}

fn at_least<T: Copy + PartialOrd + ToString>(
    key: &'static str,
    value: T,
    least: T,
    allowed: &'static str,
) -> Result<(), ConfigError> {
    if value >= least {
        Ok(())
    } else {
        Err(ConfigError { key, value: value.to_string(), allowed })
    }
}

fn share(key: &'static str, value: f32) -> Result<(), ConfigError> {
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(ConfigError { key, value: value.to_string(), allowed: "0 to 1" })
    }
}

fn positive(key: &'static str, value: f32, or_zero: bool) -> Result<(), ConfigError> {
    if value.is_finite() && (value > 0.0 || or_zero && value == 0.0) {
        Ok(())
    } else {
        let allowed = if or_zero { "a number, at least 0" } else { "a number above 0" };
        Err(ConfigError { key, value: value.to_string(), allowed })
    }
}
