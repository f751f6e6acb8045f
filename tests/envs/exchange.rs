//! Objects that are alike obey the same physics when they change names.

use crate::support::{random_action, seen_clearly};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::SignedIndex;
use rher_core::goal::Achieved;
use rher_envs::{EnvVisitor, Layout, Simulated, Task};

#[test]
fn exchanged_objects_are_seen_in_each_others_place() {
    let mut permutations = Vec::new();
    for task in Task::ALL {
        let count = task.visit_with(&seen_clearly(*task), Exchanged(*task)).unwrap();
        permutations.extend((count > 0).then(|| (task.name(), count)));
    }
    assert_eq!(permutations, [("dpush", 1), ("stack", 1), ("tpush", 5), ("tstack", 5)]);
}

struct Exchanged(Task);

impl EnvVisitor for Exchanged {
    /// Orders besides the objects' own.
    type Output = usize;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> usize {
        let task = self.0;
        let (mut env, mut image) = (build(), build());
        let permutations = env.spec().permutations.clone();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let (mut seen, mut expected) = (observation.clone(), observation.clone());
        for exchange in &permutations {
            for seed in 0..10 {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let start = env.reset(seed, &mut observation).unwrap();
                let layout = Layout::new(
                    start.achieved.0.reordered(&exchange.order).objects,
                    *start.desired.reordered(&exchange.order).objects(),
                );
                image.arrange(layout, &mut seen).unwrap();
                'episode: for step in 0..25 {
                    SignedIndex::apply(&exchange.observation, &observation, &mut expected);
                    for (i, (seen, expected)) in seen.iter().zip(&expected).enumerate() {
                        assert!(
                            (seen - expected).abs() < 1e-3,
                            "{task}, seed {seed}, step {step}, number {i}: {seen}, not {expected}"
                        );
                    }
                    let action = &random_action(&mut rng)[..env.spec().action_dim];
                    let Achieved(here) = env.step(action, &mut observation).unwrap();
                    image.step(action, &mut seen).unwrap();
                    // Contacts are solved in the order of the objects.
                    if here.objects.iter().any(|object| (object - here.gripper).norm() < 0.06) {
                        break 'episode;
                    }
                }
            }
        }
        permutations.len()
    }
}
