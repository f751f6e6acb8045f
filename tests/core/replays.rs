//! The ring of episodes.

use crate::toy::Magnet;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::Env as _;
use rher_core::episode::{Episode, rollout};
use rher_core::goal::Achieved;
use rher_core::replay::{Replay, StepIndex};
use std::convert::Infallible;

fn episodes(count: u64) -> Vec<Episode<1>> {
    let mut env = Magnet::<1>::new();
    (0..count)
        .map(|seed| {
            rollout(&mut env, seed, |_, action| {
                action.fill(0.5);
                Ok(())
            })
            .unwrap()
        })
        .collect()
}

#[test]
fn the_oldest_episode_makes_room_for_the_newest() {
    let spec = Magnet::<1>::new().spec().clone();
    let mut replay = Replay::new(&spec, 3 * spec.episode_steps + 1);
    let episodes = episodes(5);
    for episode in &episodes {
        replay.push(episode);
    }
    assert_eq!((replay.capacity(), replay.episodes(), replay.pushed()), (3, 3, 5));
    assert_eq!(replay.newest(3).collect::<Vec<_>>(), episodes[2..]);
    for (slot, stored) in [(0, &episodes[3]), (1, &episodes[4]), (2, &episodes[2])] {
        let scenes = (0..=spec.episode_steps).map(|step| replay.scene(StepIndex { slot, step }));
        assert!(scenes.eq(stored.achieved.iter().copied()));
    }
}

#[test]
fn a_restored_replay_is_drawn_from_alike() {
    let spec = Magnet::<1>::new().spec().clone();
    for count in [1, 3, 7] {
        let episodes = episodes(count);
        let mut replay = Replay::new(&spec, 3 * spec.episode_steps);
        for episode in &episodes {
            replay.push(episode);
        }
        let restored = Replay::restore(&spec, 3 * spec.episode_steps, count, |index| {
            Ok::<_, Infallible>(episodes[index as usize].clone())
        })
        .unwrap();
        assert_eq!(restored.pushed(), count);
        let mut one = ChaCha8Rng::seed_from_u64(1);
        let mut other = one.clone();
        for _ in 0..50 {
            let (a, b) = (replay.draw(&mut one), restored.draw(&mut other));
            assert_eq!(replay.action(a), restored.action(b));
            assert_eq!(replay.observation(a), restored.observation(b));
            assert_eq!(replay.scene(a), restored.scene(b));
        }
    }
}

#[test]
fn a_place_that_is_not_a_number_is_named() {
    /// Breaks what it is given at the first step.
    struct Broken(Magnet<1>, fn(&mut [f32], &mut Achieved<1>));
    impl rher_core::env::Env<1> for Broken {
        fn spec(&self) -> &rher_core::env::EnvSpec<1> {
            self.0.spec()
        }
        fn reset(
            &mut self,
            seed: u64,
            observation: &mut [f32],
        ) -> Result<rher_core::env::Start<1>, rher_core::env::EnvError> {
            self.0.reset(seed, observation)
        }
        fn step(
            &mut self,
            action: &[f32],
            observation: &mut [f32],
        ) -> Result<Achieved<1>, rher_core::env::EnvError> {
            let mut achieved = self.0.step(action, observation)?;
            self.1(observation, &mut achieved);
            Ok(achieved)
        }
    }
    let error = |broken: fn(&mut [f32], &mut Achieved<1>)| {
        let mut env = Broken(Magnet::new(), broken);
        rollout(&mut env, 7, |_, _| Ok(())).unwrap_err().to_string()
    };
    assert_eq!(
        error(|observation, _| observation[3] = f32::NAN),
        "the environment returned NaN in observation[3] at step 1 of the episode with seed 7, \
         expected finite numbers"
    );
    assert_eq!(
        error(|_, achieved| achieved.0.objects[0].y = f32::INFINITY),
        "the environment returned inf in the position of object 1 at step 1 of the episode with \
         seed 7, expected finite numbers"
    );
}
