//! The mirror image of an episode obeys the same physics.

use crate::support::{random_action, seen_clearly};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::{Mirror, SignedIndex};
use rher_core::goal::{Achieved, Position, Scene};
use rher_envs::{EnvVisitor, Layout, Simulated, Task};

#[test]
fn mirrored_actions_lead_to_mirrored_observations() {
    for task in Task::ALL {
        task.visit_with(&seen_clearly(*task), Mirrored(*task)).unwrap();
    }
}

struct Mirrored(Task);

impl EnvVisitor for Mirrored {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let task = self.0;
        let (mut env, mut image) = (build(), build());
        let spec = env.spec().clone();
        let mut observation = vec![0.0; spec.obs_dim];
        let mut seen = observation.clone();
        let mut expected = observation.clone();
        for (mirror, seed) in
            spec.mirrors.iter().flat_map(|mirror| (0..20).map(move |s| (mirror, s)))
        {
            // Far from its first place the arm is stretched in front and folded behind.
            let (far, later) = if mirror.axis == 1 { (f32::INFINITY, 1e-3) } else { (0.1, 5e-3) };
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let start = env.reset(seed, &mut observation).unwrap();
            let layout = mirrored_layout(mirror, start.achieved, start.desired.objects());
            image.arrange(layout, &mut seen).unwrap();
            SignedIndex::apply(&mirror.observation, &observation, &mut expected);
            assert_near(task, &seen, &expected, 1e-5);
            // Held for a few steps each, so that the hand gets somewhere.
            'episode: for _ in 0..5 {
                let action = &random_action(&mut rng)[..spec.action_dim];
                let mut mirrored = vec![0.0; action.len()];
                SignedIndex::apply(&mirror.action, action, &mut mirrored);
                for _ in 0..5 {
                    let Achieved(here) = env.step(action, &mut observation).unwrap();
                    image.step(&mirrored, &mut seen).unwrap();
                    // Contacts are solved in an order that has no mirror image.
                    let off = (here.gripper - start.achieved.0.gripper).norm();
                    if touched(&here, &start.achieved.0) || off > far {
                        break 'episode;
                    }
                    SignedIndex::apply(&mirror.observation, &observation, &mut expected);
                    assert_near(task, &seen, &expected, later);
                }
            }
        }
    }
}

fn touched<const N: usize>(now: &Scene<N>, start: &Scene<N>) -> bool {
    let near = |object: &Position| (object - now.gripper).norm() < 0.06;
    let moved = |now: &Position, start: &Position| (now - start).norm() > 1e-4;
    now.objects.iter().zip(&start.objects).any(|(now, start)| near(now) || moved(now, start))
}

fn mirrored_layout<const N: usize>(
    mirror: &Mirror,
    achieved: Achieved<N>,
    targets: &[Position; N],
) -> Layout<N> {
    Layout::new(achieved.0.objects.map(|p| mirror.position(p)), targets.map(|p| mirror.position(p)))
}

fn assert_near(task: Task, seen: &[f32], expected: &[f32], tolerance: f32) {
    for (i, (seen, expected)) in seen.iter().zip(expected).enumerate() {
        assert!((seen - expected).abs() < tolerance, "{task}, number {i}: {seen}, not {expected}");
    }
}

/// A block that is pushed off its center turns one way, its mirror image the other.
#[test]
fn a_block_turns_the_other_way_in_the_mirror() {
    let turned = |side: f32| {
        let mut push = crate::support::push();
        push.put(1.45, 0.7491 + side * 0.03);
        push.repeat(4, [1.0, 0.0, 0.0, 0.0]);
        push.observation.clone()
    };
    let (here, there) = (turned(1.0), turned(-1.0));
    let mut push = crate::support::push();
    push.reset(0);
    let mirror = rher_core::env::Env::spec(&push.env).mirrors[0].clone();
    let mut expected = vec![0.0; here.len()];
    SignedIndex::apply(&mirror.observation, &here, &mut expected);
    assert!(here[13] > 0.1, "yaw {}", here[13]);
    // Contacts are solved one after the other, and their order has no mirror image.
    assert_near(Task::PUSH, &there, &expected, 0.05);
}
