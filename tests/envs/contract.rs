//! What every task promises.

use crate::support::{is_met, random_action, seen_clearly};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Achieved;
use rher_core::testing::check_env;
use rher_envs::{EnvVisitor, Simulated, Task};

#[test]
fn every_task_keeps_the_contract() {
    for task in Task::ALL {
        task.visit_with(&seen_clearly(*task), Contract(*task)).unwrap();
    }
}

struct Contract(Task);

impl EnvVisitor for Contract {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let task = self.0;
        let checked = check_env(&build).unwrap();
        let mut env = build();
        let spec = env.spec().clone();
        assert_eq!(checked.symmetries, spec.mirrors.len() + spec.permutations.len(), "{task}");
        assert_eq!(spec.name, task.name());

        let mut observation = vec![f32::NAN; spec.obs_dim];
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for seed in 0..20 {
            let start = env.reset(seed, &mut observation).unwrap();
            check_frame(task, start.achieved, &observation);
            for _ in 0..spec.episode_steps {
                let action = &random_action(&mut rng)[..spec.action_dim];
                let achieved = env.step(action, &mut observation).unwrap();
                check_frame(task, achieved, &observation);
            }
        }

        let mut fits = vec![0.0; spec.obs_dim];
        let width = spec.action_dim;
        assert!(env.step(&vec![0.0; width - 1], &mut fits).is_err(), "{task}");
        assert!(env.step(&vec![f32::NAN; width], &mut fits).is_err(), "{task}");
        assert!(env.reset(0, &mut vec![0.0; spec.obs_dim + 1]).is_err(), "{task}");
    }
}

fn check_frame<const N: usize>(task: Task, achieved: Achieved<N>, observation: &[f32]) {
    let gripper = achieved.0.gripper.coords;
    assert!(observation.windows(3).any(|seen| seen == gripper.as_slice()), "{task}");
    if observation.len() == 25 {
        let object = achieved.0.objects[0];
        assert_eq!(observation[3..6], *object.coords.as_slice(), "{task}");
        assert_eq!(observation[6..9], *(object - achieved.0.gripper).as_slice(), "{task}");
    }
}

#[test]
fn errors_carry_the_numbers() {
    let mut push = crate::support::push();
    let error = push.env_step_error(&[0.0; 3]);
    assert_eq!(error, "action has 3 numbers, expected 4");
    let error = push.env_step_error(&[0.0, f32::NAN, 0.0, 0.0]);
    assert_eq!(error, "number 1 of the action is NaN");
}

impl<E: Simulated<1>> crate::support::Stand<E> {
    fn env_step_error(&mut self, action: &[f32]) -> String {
        self.env.step(action, &mut self.observation).unwrap_err().to_string()
    }
}

#[test]
fn actions_are_clipped() {
    let (mut far, mut full) = (crate::support::push(), crate::support::push());
    far.step([9.0, f32::NEG_INFINITY, 3.0, 0.0]);
    full.step([1.0, -1.0, 1.0, 0.0]);
    assert_eq!(far.scene, full.scene);
}

#[test]
fn names_lead_to_tasks_and_unknown_ones_to_the_list() {
    for task in Task::ALL {
        assert_eq!(task.to_string().parse(), Ok(*task));
    }
    let error = "pushh".parse::<Task>().unwrap_err().to_string();
    assert!(error.contains("pushh") && error.contains("reach, push, pick, "), "{error}");
}

/// The share of Fetch episodes that begin solved, as computed from their geometry.
#[test]
fn as_many_episodes_begin_solved_as_in_fetch() {
    let expected: [(Task, f32); 7] = [
        (Task::REACH, 0.0194),
        (Task::PUSH, 0.069),
        (Task::PICK, 0.037),
        (Task::SLIDE, 0.003),
        (Task::INSERT, 0.0),
        (Task::DPUSH, 0.018),
        (Task::TPUSH, 0.005),
    ];
    for (task, expected) in expected {
        let share = task.visit(BeginSolved);
        let sampling_error = (expected * (1.0 - expected) / 10_000.0).sqrt();
        println!("{task}: {share} of the episodes begin solved");
        assert!((share - expected).abs() <= 4.0 * sampling_error, "{task}: {share}");
    }
}

struct BeginSolved;

impl EnvVisitor for BeginSolved {
    type Output = f32;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> f32 {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let mut solved = 0.0;
        for seed in 0..10_000 {
            let start = env.reset(seed, &mut observation).unwrap();
            solved += f32::from(u8::from(is_met(&env, start.achieved, &start.desired)));
        }
        solved / 10_000.0
    }
}

#[test]
fn doing_nothing_and_random_actions_seldom_succeed() {
    for task in Task::ALL.iter().filter(|task| **task != Task::REACH) {
        let still = task.visit(Succeed { random: false });
        let random = task.visit(Succeed { random: true });
        println!("{task}: solved by doing nothing {still}, at random {random}");
        assert!(still < 0.12 && random < 0.2, "{task}: still {still}, random {random}");
    }
}

struct Succeed {
    random: bool,
}

impl EnvVisitor for Succeed {
    type Output = f32;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> f32 {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut solved = 0.0;
        for seed in 0..300 {
            let start = env.reset(seed, &mut observation).unwrap();
            let mut achieved = start.achieved;
            for _ in 0..env.spec().episode_steps {
                let action = if self.random { random_action(&mut rng) } else { [0.0; 4] };
                achieved = env.step(&action[..env.spec().action_dim], &mut observation).unwrap();
            }
            solved += f32::from(u8::from(is_met(&env, achieved, &start.desired)));
        }
        solved / 300.0
    }
}
