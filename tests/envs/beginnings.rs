//! Episodes whose beginning is chosen, as a whole or in part, and what they are rewarded by.

use rher_core::env::Env as _;
use rher_core::goal::Position;
use rher_envs::tasks::{DPush, Push, Reach};
use rher_envs::{
    AutoReset, Chosen, Pool, RewardKind, Scenario, Simulated as _, Simulation, achieved_goal,
};

const PLACE: [f32; 3] = [1.4, 0.65, 0.42469];

fn bits(numbers: &[f32]) -> Vec<u32> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// First observation, where the objects are, and where they should be.
type First<const N: usize> = (Vec<f32>, [Position; N], [Position; N]);

fn first<S: Scenario<N>, const N: usize>(seed: u64, chosen: &Chosen) -> Result<First<N>, String> {
    let mut env = Simulation::<S, N>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    let start = env.reset_with(seed, chosen, &mut observation).map_err(|error| {
        std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string)
    })?;
    Ok((observation, start.achieved.0.objects, *start.desired.objects()))
}

#[test]
fn what_is_not_chosen_is_that_of_the_seed() {
    let nothing = Chosen::default();
    let (drawn, objects, targets) = first::<Push, 1>(7, &nothing).unwrap();
    let goal = Chosen { targets: Some(PLACE.to_vec()), ..Chosen::default() };
    let (seen, same, chosen) = first::<Push, 1>(7, &goal).unwrap();
    assert_eq!((seen, same), (drawn, objects));
    assert_eq!(chosen, [Position::from(PLACE)]);

    let layout = Chosen { objects: Some(PLACE.to_vec()), ..Chosen::default() };
    let (_, [object], same) = first::<Push, 1>(7, &layout).unwrap();
    assert!((object - Position::from(PLACE)).norm() < 1e-3, "{object}");
    assert_eq!(same, targets);
}

#[test]
fn what_cannot_be_is_an_error() {
    let objects = |numbers: &[f32]| Chosen { objects: Some(numbers.to_vec()), ..Chosen::default() };
    assert_eq!(
        first::<DPush, 2>(0, &objects(&PLACE)).unwrap_err(),
        "places of objects: 3 numbers, expected 6"
    );
    let turns = Chosen { turns: Some(vec![f32::NAN]), ..Chosen::default() };
    assert_eq!(first::<Push, 1>(0, &turns).unwrap_err(), "number 0 of the turns is NaN");
    let wrong = first::<Reach, 1>(0, &objects(&[1.0, 0.3, 0.9])).unwrap_err();
    assert!(wrong.starts_with("object 1 cannot start at [1.0, 0.3, 0.9]: this task"), "{wrong}");
}

#[test]
fn a_pool_returns_to_a_beginning_that_was_chosen() {
    let pool = || {
        let envs = (0..2).map(|_| Simulation::<Push, 1>::new()).collect();
        Pool::new(envs, 1, AutoReset::NextStep).unwrap()
    };
    let goal = Chosen { targets: Some(PLACE.to_vec()), ..Chosen::default() };
    let mut first = pool();
    first.reset(&[1, 2]).unwrap();
    first.reset_with(&[false, true], &[goal.clone(), goal]).unwrap();
    assert_ne!(bits(&first.now().desired[..3]), bits(&PLACE));
    assert_eq!(bits(&first.now().desired[3..]), bits(&PLACE));
    first.step(&[0.5; 8]).unwrap();
    let mut second = pool();
    second.play(&first.record()).unwrap();
    first.step(&[0.5; 8]).unwrap();
    second.step(&[0.5; 8]).unwrap();
    assert_eq!(first.now(), second.now());
    assert_eq!(bits(&second.now().desired[3..]), bits(&PLACE));
}

#[test]
fn dense_rewards_are_distances_over_all_objects() {
    let env = Simulation::<DPush, 2>::new();
    let at = |x, y| [Position::new(x, 0.0, 0.0), Position::new(0.0, y, 0.0)];
    let reward = |kind: RewardKind, x, y| kind.of_goals(env.spec(), at(x, y), at(0.0, 0.0));
    let rewards = [
        reward(RewardKind::Dense, 3.0, 4.0),
        reward(RewardKind::Sparse, 3.0, 4.0),
        reward(RewardKind::Sparse, 0.01, 0.01),
    ];
    assert_eq!(bits(&rewards), bits(&[-5.0, -1.0, 0.0]));

    let envs = vec![Simulation::<DPush, 2>::new()];
    let mut pool = Pool::new(envs, 1, AutoReset::Never).unwrap().with_rewards(RewardKind::Dense);
    pool.reset(&[3]).unwrap();
    pool.step(&[0.2; 4]).unwrap();
    let mut env = Simulation::<DPush, 2>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    let start = env.reset(3, &mut observation).unwrap();
    let achieved = env.step(&[0.2; 4], &mut observation).unwrap();
    let spec = env.spec();
    let expected = RewardKind::Dense.of_scene(spec, &achieved, &start.desired);
    assert_eq!(bits(pool.rewards()), bits(&[expected]));
    let (goal, desired) = (achieved_goal(spec, &achieved), *start.desired.objects());
    let of_goals = RewardKind::Dense.of_goals(spec, goal, desired);
    assert_eq!(of_goals.to_bits(), expected.to_bits());
}
