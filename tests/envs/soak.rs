//! Random actions, for long.

use crate::support::random_action;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::episode::rollout;
use rher_core::goal::Achieved;
use rher_envs::{EnvVisitor, Simulated, Task};

#[test]
fn every_task_withstands_random_actions() {
    soak(20_000);
}

/// `cargo test --release -p rher-envs --test envs -- --ignored --nocapture million`
#[test]
#[ignore = "takes minutes for each task"]
fn every_task_withstands_a_million_random_actions() {
    soak(1_000_000);
}

fn soak(steps: usize) {
    println!(
        "task           steps      episodes  fastest (m/s)  episodes with an object off the table"
    );
    for task in Task::ALL {
        let Soaked { steps, episodes, fastest, fell } = task.visit(Soak { steps });
        println!("{task:<14} {steps:<10} {episodes:<9} {fastest:<14.2} {fell}");
        assert!(fastest < 10.0, "{task}: {fastest} m/s");
    }
}

struct Soak {
    steps: usize,
}

struct Soaked {
    steps: usize,
    episodes: u64,
    fastest: f32,
    fell: usize,
}

impl EnvVisitor for Soak {
    type Output = Soaked;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Soaked {
        let mut env = Truthful(build());
        let length = env.0.spec().episode_steps;
        let mut soaked = Soaked { steps: 0, episodes: 0, fastest: 0.0, fell: 0 };
        while soaked.steps < self.steps {
            let mut rng = ChaCha8Rng::seed_from_u64(soaked.episodes);
            let episode = rollout(&mut env, soaked.episodes, |_, action| {
                let width = action.len();
                action.copy_from_slice(&random_action(&mut rng)[..width]);
                Ok(())
            })
            .unwrap();
            assert_eq!(episode.achieved.len(), length + 1);
            for frames in episode.achieved.windows(2) {
                let pairs = frames[0].0.objects.iter().zip(&frames[1].0.objects);
                let speeds = pairs.map(|(before, after)| (after - before).norm() / 0.04);
                soaked.fastest = speeds.fold(soaked.fastest, f32::max);
            }
            let end = &episode.achieved[length].0;
            soaked.fell += usize::from(end.objects.iter().any(|object| object.z < 0.3));
            soaked.steps += length;
            soaked.episodes += 1;
        }
        soaked
    }
}

/// An environment that tells where everything really is.
struct Truthful<E>(E);

impl<E: Simulated<N>, const N: usize> Env<N> for Truthful<E> {
    fn spec(&self) -> &EnvSpec<N> {
        self.0.spec()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        let mut start = self.0.reset(seed, observation)?;
        start.achieved = self.0.truth().unwrap_or(start.achieved);
        Ok(start)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let achieved = self.0.step(action, observation)?;
        Ok(self.0.truth().unwrap_or(achieved))
    }
}
