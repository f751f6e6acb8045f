//! The policies that ship with the program.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use rher_core::config::{EvaluationConfig, TestPolicy};
use rher_core::evaluate::evaluate;
use rher_envs::{EnvVisitor, Options, Simulated, Task};
use rher_policies::{ALL, Card, Shipped};

#[test]
fn every_task_has_a_policy() {
    let tasks: Vec<&str> = Task::ALL.iter().map(|task| task.name()).collect();
    assert_eq!(ALL.iter().map(|shipped| shipped.task).collect::<Vec<_>>(), tasks);
}

#[test]
fn every_policy_is_what_its_card_says() {
    for shipped in ALL {
        let task: Task = shipped.task.parse().unwrap();
        let Card { success, episodes, about, command, ci95, .. } = shipped.card();
        assert_eq!((shipped.card().task.as_str(), about.as_str()), (task.name(), task.about()));
        assert!(command.starts_with(&format!("rher train {task} ")), "{command}");
        assert!(episodes == 1000 && ci95[0] <= success.into() && ci95[1] >= success.into());
        let policy = shipped.policy();
        let control = policy.control();
        assert_eq!(control.rate_hz, Some(25.0), "{task}");
        assert_eq!(control.observation_units.len(), policy.info().obs_dim, "{task}");
        assert_eq!(policy.names().action.len(), policy.info().action_dim, "{task}");

        let found = task.visit(Judge(shipped));
        assert!(found >= success - 0.05, "{task}: {found}, and its card says {success}");
    }
}

/// All of it, with room for what compression does not take.
#[test]
fn all_of_it_is_small() {
    let bytes: usize = ALL.iter().map(|s| s.policy.len() + s.metrics.len() + s.config.len()).sum();
    assert!(bytes < 5_000_000, "{bytes} bytes");
}

/// The success of a shipped policy in 100 episodes.
struct Judge(&'static Shipped);

impl EnvVisitor for Judge {
    type Output = f32;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> f32 {
        let policy = self.0.policy();
        let options: Options = policy.info().variant.parse().unwrap();
        let mut envs = [build(), build()];
        assert_eq!(envs[0].options(), &options);
        let config =
            EvaluationConfig { every_episodes: 1, episodes: 100, subtask_episodes: 0, env_seed: 2 };
        evaluate(&mut envs, &policy, &config, TestPolicy::Final).unwrap().success_final
    }
}
