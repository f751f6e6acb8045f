//! What can be set, and what is drawn anew for every episode.

use crate::support::random_action;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::Env as _;
use rher_envs::tasks::{ObstaclePush, Push};
use rher_envs::{EnvVisitor, OptionValue, Options, Randomize, Simulated, Simulation, Task};

/// Everything as far from its default as it may be.
fn wildest() -> Randomize {
    Randomize {
        friction: [0.2, 3.0],
        mass: [0.2, 5.0],
        size: [0.8, 1.2],
        sensor_noise: [0.0, 0.05],
        action_delay: [0, 5],
    }
}

fn with(task: Task, randomize: Randomize) -> Options {
    Options { randomize, ..Options::of(task.options()) }
}

#[test]
fn the_obstacle_can_be_hidden() {
    let mut options = Options::of(Task::OBSTACLE_PUSH.options());
    let shown = Simulation::<ObstaclePush, 1>::with(&options).unwrap();
    options.task.0.insert("observe_obstacle".to_owned(), OptionValue::Flag(false));
    let hidden = Simulation::<ObstaclePush, 1>::with(&options).unwrap();
    let observe = |mut env: Simulation<ObstaclePush, 1>| {
        let mut observation = vec![0.0; 28];
        env.reset(5, &mut observation).unwrap();
        observation
    };
    let (shown, hidden) = (observe(shown), observe(hidden));
    assert_eq!(shown[..25], hidden[..25]);
    assert!(shown[25].abs().max(shown[26].abs()) > 0.04);
    assert_eq!(hidden[25..], [0.0; 3]);
}

#[test]
fn what_does_not_fit_is_told() {
    let error = |name: &str, value| {
        let mut options = Options::of(&[]);
        options.task.0.insert(name.to_owned(), value);
        options.check(Task::OBSTACLE_PUSH.options()).unwrap_err().to_string()
    };
    assert_eq!(error("noise", OptionValue::Count(1)), "there is no setting `task.noise`");
    assert_eq!(
        error("observe_obstacle", OptionValue::Number(0.5)),
        "`task.observe_obstacle` is 0.5, expected true or false"
    );
    let impossible = [
        Randomize { friction: [0.0, 1.0], ..Randomize::default() },
        Randomize { mass: [2.0, 1.0], ..Randomize::default() },
        Randomize { size: [1.0, f32::NAN], ..Randomize::default() },
        Randomize { sensor_noise: [0.0, 1.0], ..Randomize::default() },
        Randomize { action_delay: [0, 6], ..Randomize::default() },
    ];
    for randomize in impossible {
        assert!(with(Task::PUSH, randomize).check(&[]).is_err());
    }
    let bad = Randomize { mass: [2.0, 1.0], ..Randomize::default() };
    assert_eq!(
        with(Task::PUSH, bad).check(&[]).unwrap_err().to_string(),
        "`randomize.mass` is [2, 1], expected [low, high] with 0.2 ≤ low ≤ high ≤ 5"
    );
}

#[test]
fn a_state_of_other_options_is_an_error() {
    let options = with(Task::PUSH, Randomize { mass: [0.5, 2.0], ..Randomize::default() });
    let heavy = Simulation::<Push, 1>::with(&options).unwrap();
    let mut push = Simulation::<Push, 1>::new();
    let error = push.return_to(&heavy.snapshot().unwrap()).unwrap_err().to_string();
    assert!(error.contains("mass: [0.5, 2.0]") && error.contains("mass: [1.0, 1.0]"), "{error}");
}

#[test]
fn randomized_episodes_repeat_and_stay_sound() {
    for task in Task::ALL {
        task.visit_with(&with(*task, wildest()), Wild(*task)).unwrap();
    }
}

struct Wild(Task);

impl EnvVisitor for Wild {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let task = self.0;
        let (mut env, mut again) = (build(), build());
        let spec = env.spec().clone();
        let (mut seen, mut repeated) = (vec![0.0; spec.obs_dim], vec![0.0; spec.obs_dim]);
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let start = env.reset(seed, &mut seen).unwrap();
            assert_eq!(start, again.reset(seed, &mut repeated).unwrap(), "{task} {seed}");
            let mut before = env.truth().unwrap().0;
            for _ in 0..spec.episode_steps {
                let action = &random_action(&mut rng)[..spec.action_dim];
                let achieved = env.step(action, &mut seen).unwrap();
                assert_eq!(achieved, again.step(action, &mut repeated).unwrap(), "{task} {seed}");
                assert_eq!(seen, repeated, "{task} {seed}");
                assert!(seen.iter().all(|x| x.is_finite()), "{task} {seed}");
                let now = env.truth().unwrap().0;
                for (now, before) in now.objects.iter().zip(before.objects) {
                    let speed = (now - before).norm() / 0.04;
                    assert!(speed < 10.0, "{task} {seed}: {speed} m/s");
                }
                before = now;
            }
        }
    }
}

#[test]
fn mass_friction_and_size_make_a_difference() {
    let pushed = |randomize: Randomize| {
        let mut push = Simulation::<Push, 1>::with(&with(Task::PUSH, randomize)).unwrap();
        let mut observation = vec![0.0; 25];
        let block = rher_core::goal::Position::new(1.45, 0.7491, 0.42489);
        push.arrange(rher_envs::Layout::new([block], [block]), &mut observation).unwrap();
        let rest = push.step(&[0.0; 4], &mut observation).unwrap().0.objects[0].z;
        for action in [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0] {
            push.step(&[action, 0.0, 0.0, 0.0], &mut observation).unwrap();
        }
        (observation[3] - 1.45, rest)
    };
    let (usual, rest) = pushed(Randomize::default());
    assert!((rest - 0.425).abs() < 2e-4, "{rest}");
    let (slippery, _) = pushed(Randomize { friction: [0.2; 2], ..Randomize::default() });
    assert!(slippery > usual + 0.02, "{slippery} {usual}");
    let (_, high) = pushed(Randomize { size: [1.2; 2], ..Randomize::default() });
    assert!((high - 0.430).abs() < 2e-4, "{high}");
    let (heavy, rest) = pushed(Randomize { mass: [5.0; 2], ..Randomize::default() });
    assert!((heavy - usual).abs() > 1e-3 && (rest - 0.425).abs() < 2e-4, "{heavy} {usual} {rest}");
}

#[test]
fn late_actions_are_late() {
    let late = Randomize { action_delay: [2; 2], ..Randomize::default() };
    let mut late = Simulation::<Push, 1>::with(&with(Task::PUSH, late)).unwrap();
    let mut push = Simulation::<Push, 1>::new();
    let mut observation = vec![0.0; 25];
    late.reset(1, &mut observation).unwrap();
    push.reset(1, &mut observation).unwrap();
    let action = [0.5, 1.0, 0.0, 0.0];
    for _ in 0..2 {
        push.step(&[0.0; 4], &mut observation).unwrap();
        late.step(&action, &mut observation).unwrap();
    }
    for _ in 0..3 {
        let achieved = push.step(&action, &mut observation).unwrap();
        assert_eq!(late.step(&action, &mut observation).unwrap(), achieved);
    }
}
