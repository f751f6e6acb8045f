//! Equal seeds and actions give equal bits.

use crate::support::random_action;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Achieved;
use rher_envs::{EnvVisitor, Simulated, Task};

/// Steps of a test episode.
const STEPS: usize = 60;

#[test]
fn an_episode_repeats_bit_by_bit() {
    for task in Task::ALL {
        task.visit(Repeat(*task));
    }
}

struct Repeat(Task);

impl EnvVisitor for Repeat {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let task = self.0;
        for seed in 0..20 {
            let first = episode(&mut build(), seed);
            let mut used = build();
            episode(&mut used, seed + 1000);
            assert_eq!(first, episode(&mut used, seed), "{task} {seed}: after another episode");

            let elsewhere = std::thread::scope(|scope| {
                let threads = [0; 2].map(|_| scope.spawn(|| episode(&mut build(), seed)));
                threads.map(|thread| thread.join().unwrap())
            });
            assert_eq!(elsewhere, [first.clone(), first.clone()], "{task} {seed}: on threads");

            let cut = ChaCha8Rng::seed_from_u64(seed).random_range(1..STEPS);
            let mut env = build();
            let actions = actions(seed);
            let mut observation = start(&mut env, seed);
            run(&mut env, &actions[..cut], &mut observation);
            let state = env.snapshot().unwrap();
            run(&mut env, &actions[cut..], &mut observation);
            env.return_to(&state).unwrap();
            let rest = run(&mut env, &actions[cut..], &mut observation);
            assert_eq!(first[cut..], rest, "{task} {seed}: restored at {cut}");
            used.return_to(&state).unwrap();
            let rest = run(&mut used, &actions[cut..], &mut observation);
            assert_eq!(first[cut..], rest, "{task} {seed}: restored elsewhere at {cut}");
        }
    }
}

/// What is seen and achieved at each step, as bits.
type Bits = Vec<Vec<u32>>;

fn episode<const N: usize>(env: &mut impl Simulated<N>, seed: u64) -> Bits {
    let mut observation = start(env, seed);
    run(env, &actions(seed), &mut observation)
}

fn start<const N: usize>(env: &mut impl Simulated<N>, seed: u64) -> Vec<f32> {
    let mut observation = vec![0.0; env.spec().obs_dim];
    env.reset(seed, &mut observation).unwrap();
    observation
}

fn actions(seed: u64) -> Vec<[f32; 4]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..STEPS).map(|_| random_action(&mut rng)).collect()
}

fn run<const N: usize>(
    env: &mut impl Simulated<N>,
    actions: &[[f32; 4]],
    observation: &mut [f32],
) -> Bits {
    let width = env.spec().action_dim;
    actions
        .iter()
        .map(|action| {
            let Achieved(scene) = env.step(&action[..width], observation).unwrap();
            let positions = std::iter::once(scene.gripper).chain(scene.objects);
            let coordinates = positions.flat_map(|p| [p.x, p.y, p.z]);
            observation.iter().copied().chain(coordinates).map(f32::to_bits).collect()
        })
        .collect()
}
