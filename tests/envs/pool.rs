//! Many environments, stepped together.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::seed::{Purpose, Seed};
use rher_envs::tasks::{Push, Reach};
use rher_envs::{AutoReset, EnvVisitor, Frames, Pool, Simulated, Simulation, Task};
use std::num::NonZeroUsize;

fn pool(envs: usize, threads: usize, auto_reset: AutoReset) -> Pool<Simulation<Push, 1>, 1> {
    Pool::new((0..envs).map(|_| Simulation::new()).collect(), threads, auto_reset).unwrap()
}

#[test]
fn every_row_is_what_its_environment_alone_would_be() {
    for task in Task::ALL {
        task.visit(Alike(*task));
    }
}

struct Alike(Task);

impl EnvVisitor for Alike {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        const ENVS: usize = 3;
        let task = self.0;
        let run = |threads| {
            let envs = (0..ENVS).map(|_| build()).collect();
            let mut pool = Pool::new(envs, threads, AutoReset::NextStep).unwrap();
            pool.reset(&[4, 5, 6]).unwrap();
            let (action, steps) = (pool.spec().action_dim, pool.spec().episode_steps);
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let mut seen = vec![(pool.now().clone(), pool.rewards().to_vec())];
            for _ in 0..steps + 3 {
                let mut actions = vec![0.0; ENVS * action];
                actions.fill_with(|| rng.random_range(-1.0..1.0));
                pool.step(&actions).unwrap();
                seen.push((pool.now().clone(), pool.rewards().to_vec()));
            }
            seen
        };
        let one: Vec<(Frames, Vec<f32>)> = run(1);
        assert!(one == run(2), "{task}: threads make a difference");

        let mut env = build();
        let spec = env.spec().clone();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut observation = vec![0.0; spec.obs_dim];
        env.reset(5, &mut observation).unwrap();
        let row = |frames: &Frames| frames.observations[spec.obs_dim..2 * spec.obs_dim].to_vec();
        assert_eq!(row(&one[0].0), observation, "{task}");
        for (frames, _) in &one[1..=spec.episode_steps] {
            let mut actions = vec![0.0; ENVS * spec.action_dim];
            actions.fill_with(|| rng.random_range(-1.0..1.0));
            env.step(&actions[spec.action_dim..2 * spec.action_dim], &mut observation).unwrap();
            assert_eq!(row(frames), observation, "{task}");
        }
        env.reset(Seed(5).episode(Purpose::Environment, 1), &mut observation).unwrap();
        assert_eq!(row(&one[spec.episode_steps + 1].0), observation, "{task}: the next episode");
    }
}

#[test]
fn the_next_step_starts_the_next_episode() {
    let mut pool = pool(2, 1, AutoReset::NextStep);
    pool.reset(&[1, 2]).unwrap();
    for step in 1..=50 {
        pool.step(&[0.0; 8]).unwrap();
        assert_eq!(pool.ended(), [step == 50; 2]);
        assert!(pool.rewards().iter().all(|reward| [-1.0, 0.0].contains(reward)));
    }
    let end = pool.now().clone();
    pool.step(&[1.0; 8]).unwrap();
    assert_eq!((pool.ended(), pool.rewards()), (&[false; 2][..], &[0.0; 2][..]));
    assert_ne!(pool.now().desired, end.desired);
}

#[test]
fn the_same_step_starts_the_next_episode_and_keeps_the_end() {
    let mut same = pool(2, 1, AutoReset::SameStep);
    let mut never = pool(2, 1, AutoReset::Never);
    same.reset(&[1, 2]).unwrap();
    never.reset(&[1, 2]).unwrap();
    for _ in 0..50 {
        same.step(&[0.3; 8]).unwrap();
        never.step(&[0.3; 8]).unwrap();
    }
    assert_eq!(same.last(), never.now());
    assert_eq!(same.ended(), [true; 2]);
    assert_eq!(same.rewards(), never.rewards());
    assert_ne!(same.now().desired, never.now().desired);
    same.step(&[0.0; 8]).unwrap();
    assert_eq!(same.ended(), [false; 2]);
}

#[test]
fn without_auto_reset_the_caller_resets() {
    let mut pool = pool(2, 2, AutoReset::Never);
    let error = pool.step(&[0.0; 8]).unwrap_err().to_string();
    assert_eq!(error, "environment 0 has to be reset before it can be stepped");
    pool.reset(&[1, 2]).unwrap();
    for _ in 0..50 {
        pool.step(&[0.0; 8]).unwrap();
    }
    pool.reset_where(&[true, false]).unwrap();
    let error = pool.step(&[0.0; 8]).unwrap_err().to_string();
    assert_eq!(error, "environment 1 has to be reset before it can be stepped");
    pool.reset_where(&[false, true]).unwrap();
    pool.step(&[0.0; 8]).unwrap();
}

#[test]
fn wrong_actions_are_told_and_large_ones_counted() {
    let mut pool = pool(2, 1, AutoReset::NextStep);
    pool.reset(&[1, 2]).unwrap();
    let error = pool.step(&[0.0; 7]).unwrap_err().to_string();
    assert_eq!(error, "actions: 7 numbers, expected 8 for 2 environments");
    let mut actions = [0.0; 8];
    actions[5] = f32::NAN;
    let before = pool.now().clone();
    let error = pool.step(&actions).unwrap_err().to_string();
    assert_eq!(error, "number 1 of the action of environment 1 is NaN");
    assert_eq!(*pool.now(), before);
    pool.step(&[2.0, 0.0, -3.0, 0.0, 1.0, -1.0, 0.0, 0.0]).unwrap();
    pool.step(&[2.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0]).unwrap();
    assert_eq!(pool.clipped(), [3, 0]);
    assert_eq!(
        Pool::<Simulation<Push, 1>, 1>::new(vec![], 1, AutoReset::Never).err().unwrap().to_string(),
        "a pool needs at least one environment"
    );
}

#[test]
fn where_the_task_is_to_reach_the_gripper_is_what_is_achieved() {
    let envs = vec![Simulation::<Reach, 1>::new()];
    let mut pool = Pool::new(envs, 1, AutoReset::Never).unwrap();
    pool.reset(&[1]).unwrap();
    pool.step(&[1.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!(pool.now().achieved, pool.now().observations[..3]);
    assert_ne!(pool.now().achieved, pool.now().desired);
}

#[test]
fn a_record_leads_another_pool_to_the_same_place() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let actions: Vec<Vec<f32>> = (0..12)
        .map(|_| {
            let mut actions = vec![0.0; 3 * 4];
            actions.fill_with(|| rng.random_range(-1.5..1.5));
            actions
        })
        .collect();
    let five = NonZeroUsize::new(5).unwrap();
    for auto_reset in [AutoReset::NextStep, AutoReset::SameStep] {
        for steps in 0..8 {
            let mut first = pool(3, 2, auto_reset).with_episode_steps(five);
            first.reset(&[7, 8, u64::MAX]).unwrap();
            actions[..steps].iter().for_each(|actions| first.step(actions).unwrap());
            let record = first.record();
            let text = serde_json::to_string(&record).unwrap();
            let mut second = pool(3, 1, auto_reset).with_episode_steps(five);
            second.play(&serde_json::from_str(&text).unwrap()).unwrap();
            assert_eq!(second.record(), record, "{auto_reset:?} {steps}");
            for actions in &actions[steps..] {
                first.step(actions).unwrap();
                second.step(actions).unwrap();
                assert_eq!(second.record(), first.record(), "{auto_reset:?} {steps}");
            }
        }
    }
    let error = pool(2, 1, AutoReset::Never).play(&pool(3, 1, AutoReset::Never).record());
    let text = error.unwrap_err().to_string();
    assert_eq!(text, "records of environments: 3 numbers, expected 2 for 2 environments");
}
