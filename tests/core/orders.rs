//! In which order a policy places its objects.

use crate::toy::{Lines, small};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::config::TrainConfig;
use rher_core::env::{Env, EnvError, EnvSpec, Permutation, SignedIndex, Start};
use rher_core::goal::{Achieved, Desired, Position, Scene};
use rher_core::train::Trainer;
use std::sync::atomic::AtomicBool;

/// The order is learned after 200 episodes, all in the given order; after that, what this world does
/// no longer depends on the order that a policy chooses.
///
/// Two objects that nobody can move. At the end of an episode both are in their places if the first
/// one lay nearer to the gripper, and else where they were.
struct NearestFirst {
    spec: EnvSpec<2>,
    scene: Scene<2>,
    targets: [Position; 2],
    step: usize,
}

impl NearestFirst {
    fn new() -> Self {
        let entry = |from| SignedIndex { from, sign: 1.0, offset: 0.0 };
        let mut spec = EnvSpec::new("nearest-first", 2, 2, 4);
        let observation = vec![entry(1), entry(0)];
        spec.permutations = vec![Permutation { order: [1, 0], observation }];
        spec.any_order = true;
        let origin = Position::origin();
        let scene = Scene::new(origin, [origin; 2]);
        Self { spec, scene, targets: [origin; 2], step: 0 }
    }

    fn observe(&self, observation: &mut [f32]) -> Achieved<2> {
        observation.copy_from_slice(&self.scene.objects.map(|object| object.x));
        Achieved(self.scene)
    }
}

impl Env<2> for NearestFirst {
    fn spec(&self) -> &EnvSpec<2> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<2>, EnvError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut place = |y| Position::new(rng.random_range(0.2..1.0), y, 0.0);
        self.scene.objects = [place(0.0), place(0.0)];
        self.targets = [place(1.0), place(1.0)];
        self.step = 0;
        let desired = Desired::of_task(self.targets);
        Ok(Start { achieved: self.observe(observation), desired })
    }

    fn step(&mut self, _: &[f32], observation: &mut [f32]) -> Result<Achieved<2>, EnvError> {
        self.step += 1;
        let [first, second] = self.scene.objects;
        if self.step == self.spec.episode_steps && first.x < second.x {
            self.scene.objects = self.targets;
        }
        Ok(self.observe(observation))
    }
}

fn config(episodes: u64) -> TrainConfig {
    let mut config = small("nearest-first", 2);
    config.agent.hidden = vec![8];
    config.env_steps = 4 * episodes;
    config.replay.updates_per_episode = 1;
    config.evaluation.every_episodes = 200;
    config
}

fn trained(config: TrainConfig, env: NearestFirst) -> Trainer<2, NearestFirst> {
    let mut trainer = Trainer::new(config, vec![env], 1).unwrap();
    trainer.run(None, &mut Lines::default(), &AtomicBool::new(false)).unwrap();
    trainer
}

/// Of 100 episodes, those in which the policy of `trainer` changes the order, and those of them in
/// which it should.
fn changed(trainer: &Trainer<2, NearestFirst>) -> [usize; 2] {
    let mut env = NearestFirst::new();
    let mut actor = trainer.policy().actor(env.spec()).unwrap();
    let mut counts = [0; 2];
    for seed in 5000..5100 {
        let Start { achieved, desired } = env.reset(seed, &mut [0.0; 2]).unwrap();
        actor.begin(&achieved, &desired).unwrap();
        let [first, second] = achieved.0.objects;
        if actor.order().is_some() {
            counts[0] += 1;
            counts[1] += usize::from(second.x < first.x);
        }
    }
    counts
}

#[test]
fn a_policy_learns_which_order_succeeds() {
    let [changed, rightly] = changed(&trained(config(200), NearestFirst::new()));
    assert!(changed > 35 && rightly > changed - 4, "{rightly} of {changed}");
}

#[test]
fn the_given_order_stays_where_there_is_no_choice_or_nothing_to_choose_by() {
    let mut without = config(200);
    without.relay.choose_order = false;
    let mut tower = NearestFirst::new();
    tower.spec.any_order = false;
    for trainer in [
        trained(config(40), NearestFirst::new()),
        trained(without, NearestFirst::new()),
        trained(config(200), tower),
    ] {
        assert_eq!(changed(&trainer), [0, 0]);
    }
}

#[test]
fn acting_in_another_order_is_acting_in_the_reordered_scene() {
    let trainer = trained(config(200), NearestFirst::new());
    let mut env = NearestFirst::new();
    let swap = env.spec().permutations[0].clone();
    let mut actor = trainer.policy().actor(env.spec()).unwrap();
    let mut seen = [0.0; 2];
    let mut swapped = 0;
    for seed in 0..20 {
        let Start { achieved, desired } = env.reset(seed, &mut seen).unwrap();
        actor.begin(&achieved, &desired).unwrap();
        let task = actor.task();
        let mut action = [0.0; 2];
        actor.act(task, &seen, &achieved, &desired, &mut action).unwrap();

        let mut given = trainer.policy().actor(env.spec()).unwrap();
        let mut expected = [0.0; 2];
        if actor.order().is_some() {
            swapped += 1;
            let mut image = [0.0; 2];
            SignedIndex::apply(&swap.observation, &seen, &mut image);
            let (scene, wishes) =
                (Achieved(achieved.0.reordered(&swap.order)), desired.reordered(&swap.order));
            given.act(task, &image, &scene, &wishes, &mut expected).unwrap();
        } else {
            given.act(task, &seen, &achieved, &desired, &mut expected).unwrap();
        }
        assert_eq!(action, expected, "seed {seed}");
    }
    assert!((1..20).contains(&swapped), "{swapped}");
}

#[test]
fn a_position_that_is_not_finite_begins_no_episode() {
    let trainer = trained(config(200), NearestFirst::new());
    let mut env = NearestFirst::new();
    let Start { mut achieved, desired } = env.reset(1, &mut [0.0; 2]).unwrap();
    achieved.0.objects[1].x = f32::NAN;
    let mut actor = trainer.policy().actor(env.spec()).unwrap();
    let error = actor.begin(&achieved, &desired).unwrap_err();
    assert!(error.to_string().contains("achieved"), "{error}");
}

#[test]
fn a_resumed_run_chooses_as_before() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = Trainer::new(config(200), vec![NearestFirst::new()], 1).unwrap();
    let stop = AtomicBool::new(false);
    first.run(Some(folder.path()), &mut Lines::default(), &stop).unwrap();
    assert!(changed(&first)[0] > 35);
    let mut resumed = Trainer::resume(folder.path(), vec![NearestFirst::new()], 1).unwrap();
    assert_eq!(resumed.policy(), first.policy());
    let mut lines = [Lines::default(), Lines::default()];
    for (trainer, lines) in [&mut first, &mut resumed].into_iter().zip(&mut lines) {
        trainer.set_env_steps(1600);
        trainer.run(None, lines, &stop).unwrap();
    }
    assert_eq!(resumed.policy(), first.policy());
}

#[test]
fn any_order_takes_a_permutation_for_every_order() {
    let mut spec = NearestFirst::new().spec;
    spec.permutations.clear();
    assert_eq!(
        spec.validate().unwrap_err().to_string(),
        "the environment `nearest-first` has `permutations` = 0 orders, expected 1, for with \
         `any_order` a policy may choose every other one"
    );
}
