//! What the loop of training counts: episodes, updates, evaluations, seeds.

use crate::toy::{Magnet, small};
use insta::assert_snapshot;
use rher_core::config::{BatchMode, TrainConfig};
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::event::{Event, Metrics, Observer, ObserverError, Seconds};
use rher_core::explore::{ActionLog, ActionSource};
use rher_core::goal::{Achieved, Desired, Position, Scene};
use rher_core::seed::{Purpose, Seed};
use rher_core::train::{Finish, TrainError, Trainer};
use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Writes down what happens.
#[derive(Default)]
struct Diary {
    lines: String,
    metrics: Vec<Metrics>,
    logs: Vec<ActionLog>,
    wants_logs: bool,
}

impl Observer for Diary {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        match event {
            Event::Progress(it) => writeln!(
                self.lines,
                "{:2} episodes, {:3} steps, {:2} updates",
                it.episodes, it.env_steps, it.updates
            )
            .unwrap(),
            Event::Evaluated(metrics) => {
                self.lines.push_str("evaluated\n");
                self.metrics.push((**metrics).clone());
            }
            Event::Explored(log) => self.logs.push((**log).clone()),
            Event::Saving => {}
            Event::Saved => self.lines.push_str("saved\n"),
            other => panic!("{other:?} is new here"),
        }
        Ok(())
    }

    fn wants(&self, episode: u64) -> bool {
        self.wants_logs && !episode.is_multiple_of(3)
    }
}

fn config() -> TrainConfig {
    let mut config = small("magnet", 1);
    config.agent.hidden = vec![8];
    config.replay.batch_size = 4;
    config.replay.updates_per_episode = 2;
    config.evaluation.episodes = 1;
    config.evaluation.subtask_episodes = 1;
    config
}

fn diary(config: &TrainConfig) -> String {
    let envs = (0..config.envs).map(|_| Magnet::<1>::new()).collect();
    let mut diary = Diary::default();
    let mut trainer = Trainer::new(config.clone(), envs, 1).unwrap();
    let finish = trainer.run(None, &mut diary, &AtomicBool::new(false)).unwrap();
    assert_eq!(finish, Finish::StepsSpent);
    diary.lines
}

#[test]
fn every_environment_adds_its_episode_and_its_updates() {
    let mut config = config();
    config.envs = 3;
    config.evaluation.every_episodes = 4;
    config.env_steps = 13 * 25;
    assert_snapshot!(diary(&config), @r"
     3 episodes,  75 steps,  6 updates
     6 episodes, 150 steps, 12 updates
    evaluated
     9 episodes, 225 steps, 18 updates
    evaluated
    12 episodes, 300 steps, 24 updates
    evaluated
    15 episodes, 375 steps, 30 updates
    evaluated
    ");
}

#[test]
fn separate_batches_are_an_update_for_each_sub_task() {
    let mut config = config();
    config.replay.batch_mode = BatchMode::Separate;
    config.env_steps = 2 * 25;
    assert_snapshot!(diary(&config), @r"
     1 episodes,  25 steps,  4 updates
     2 episodes,  50 steps,  8 updates
    evaluated
    ");
}

#[test]
fn updates_begin_after_the_warm_up() {
    let mut config = config();
    config.replay.warmup_episodes = 2;
    config.evaluation.every_episodes = 3;
    config.env_steps = 4 * 25;
    assert_snapshot!(diary(&config), @r"
     1 episodes,  25 steps,  0 updates
     2 episodes,  50 steps,  0 updates
     3 episodes,  75 steps,  2 updates
    evaluated
     4 episodes, 100 steps,  4 updates
    evaluated
    ");
}

#[test]
fn a_run_is_saved_before_its_first_step_and_after_every_evaluation() {
    let mut config = config();
    config.evaluation.every_episodes = 2;
    config.env_steps = 3 * 25;
    let folder = tempfile::tempdir().unwrap();
    let mut diary = Diary::default();
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    let stop = AtomicBool::new(true);
    let finish = trainer.run(Some(folder.path()), &mut diary, &stop).unwrap();
    assert_eq!(finish, Finish::Stopped);
    diary.lines.push_str("stopped\n");
    let finish = trainer.run(Some(folder.path()), &mut diary, &AtomicBool::new(false)).unwrap();
    assert_eq!(finish, Finish::StepsSpent);
    assert_snapshot!(diary.lines, @r"
    saved
    saved
    stopped
    saved
     1 episodes,  25 steps,  2 updates
     2 episodes,  50 steps,  4 updates
    evaluated
    saved
     3 episodes,  75 steps,  6 updates
    evaluated
    saved
    ");
}

#[test]
fn too_few_environments_are_refused() {
    let config = TrainConfig { envs: 3, ..config() };
    let Err(error) = Trainer::new(config, vec![Magnet::<1>::new(), Magnet::new()], 1) else {
        panic!("two environments were enough for three");
    };
    assert!(matches!(error, TrainError::TooFewEnvs { given: 2, expected: 3 }), "{error}");
}

#[test]
fn before_the_first_update_there_is_nothing_to_report_of_the_learner() {
    let mut config = config();
    config.replay.warmup_episodes = 9;
    config.env_steps = 25;
    let mut diary = Diary::default();
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    trainer.run(None, &mut diary, &AtomicBool::new(false)).unwrap();
    let Metrics { q_min, q_mean, q_max, critic_loss, actor_loss, .. } = diary.metrics[0];
    assert_eq!([q_min, q_mean, q_max, critic_loss, actor_loss], [0.0; 5]);
}

/// A world that writes down the seed of every episode, and in which an object is where it should
/// be, or not, as the evaluations are to find.
#[derive(Clone)]
struct Exam {
    spec: EnvSpec<1>,
    seeds: Arc<Mutex<Vec<u64>>>,
    /// Whether the task is solved, by evaluation.
    results: Vec<bool>,
    exams: usize,
    solved: bool,
}

impl Exam {
    const EVALUATION: Seed = Seed(3);

    fn new(results: &[bool]) -> Self {
        let spec = EnvSpec::new("exam", 1, 1, 2);
        Self { spec, seeds: Arc::default(), results: results.to_vec(), exams: 0, solved: false }
    }

    fn achieved(&self) -> Achieved<1> {
        // 4 cm from its target is near enough for the task, and not for a relay of half its tolerance.
        let object = if self.solved { 0.96 } else { 0.0 };
        let gripper = Position::origin();
        Achieved(Scene::new(gripper, [Position::new(object, 0.0, 0.0)]))
    }
}

impl Env<1> for Exam {
    fn spec(&self) -> &EnvSpec<1> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
        observation[0] = 0.0;
        self.seeds.lock().unwrap().push(seed);
        if seed == Self::EVALUATION.episode(Purpose::Evaluation, 0) {
            // An evaluation is an episode for each of the two sub-tasks.
            self.solved = self.results.get(self.exams / 2).is_some_and(|solved| *solved);
            self.exams += 1;
        }
        let desired = Desired::of_task([Position::new(1.0, 0.0, 0.0)]);
        Ok(Start { achieved: self.achieved(), desired })
    }

    fn step(&mut self, _action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
        observation[0] = 0.0;
        Ok(self.achieved())
    }
}

fn exam_config() -> TrainConfig {
    let mut config = config();
    config.evaluation.every_episodes = 1;
    config.evaluation.env_seed = Exam::EVALUATION.0;
    config.relay.tolerance = 0.5;
    config.env_steps = 6 * 2;
    config
}

#[test]
fn a_run_ends_after_two_consecutive_evaluations_that_are_good_enough() {
    let run = |until, results: &[bool]| {
        let config = TrainConfig { until, ..exam_config() };
        let mut trainer = Trainer::new(config, vec![Exam::new(results)], 1).unwrap();
        let finish = trainer.run(None, &mut Diary::default(), &AtomicBool::new(false)).unwrap();
        (finish, trainer.evaluations())
    };
    let (yes, no) = (true, false);
    assert_eq!(run(1.0, &[yes, no, yes, yes, yes, yes]), (Finish::Solved, 4));
    assert_eq!(run(0.1, &[yes, yes, yes]), (Finish::Solved, 2));
    assert_eq!(run(1.0, &[yes, no, yes, no, yes, no]), (Finish::StepsSpent, 6));
    assert_eq!(run(0.0, &[yes; 6]), (Finish::StepsSpent, 6), "0 never ends it");
}

#[test]
fn when_a_run_ends_can_be_changed() {
    let run = |trainer: &mut Trainer<1, Exam>| {
        trainer.run(None, &mut Diary::default(), &AtomicBool::new(false)).unwrap()
    };
    let mut trainer = Trainer::new(exam_config(), vec![Exam::new(&[true; 9])], 1).unwrap();
    trainer.set_env_steps(2 * 2);
    assert_eq!((run(&mut trainer), trainer.evaluations()), (Finish::StepsSpent, 2));
    trainer.set_env_steps(8 * 2);
    assert_eq!((run(&mut trainer), trainer.evaluations()), (Finish::StepsSpent, 8));
    trainer.set_until(0.5);
    assert_eq!((run(&mut trainer), trainer.evaluations()), (Finish::Solved, 8));
}

#[test]
fn what_evaluations_find_moves_the_guide() {
    let mut config = exam_config();
    config.exploration.success_threshold = 0.6;
    config.exploration.window = 2;
    let results = &[true, true, false, false, false, false];
    let mut diary = Diary::default();
    let mut trainer = Trainer::new(config, vec![Exam::new(results)], 1).unwrap();
    trainer.run(None, &mut diary, &AtomicBool::new(false)).unwrap();
    let guides: Vec<usize> = diary.metrics.iter().map(|metrics| metrics.guide).collect();
    // The means over two evaluations are 1/2, 1, 1/2 and 0 from then on.
    assert_eq!(guides, [1, 2, 1, 1, 1, 1]);
    // Until its next evaluation this world is as its last one found it.
    let trained: Vec<f32> = diary.metrics.iter().map(|metrics| metrics.train_success).collect();
    assert_eq!(trained, [0.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn training_and_evaluation_never_share_an_episode() {
    let mut config = exam_config();
    // The same number for both.
    config.seed = config.evaluation.env_seed;
    config.envs = 2;
    config.evaluation.every_episodes = 4;
    config.evaluation.episodes = 5;
    config.evaluation.subtask_episodes = 3;
    config.env_steps = 24 * 2;
    let seeds: Arc<Mutex<Vec<u64>>> = Arc::default();
    let env = Exam { seeds: Arc::clone(&seeds), ..Exam::new(&[]) };
    let mut trainer = Trainer::new(config.clone(), vec![env.clone(), env], 1).unwrap();
    trainer.run(None, &mut Diary::default(), &AtomicBool::new(false)).unwrap();

    let mut played = seeds.lock().unwrap().clone();
    let seed = Seed(config.seed);
    let mut expected: Vec<u64> =
        (0..24).map(|episode| seed.episode(Purpose::Environment, episode)).collect();
    for _ in 0..trainer.evaluations() {
        for episodes in [3, 5] {
            expected.extend((0..episodes).map(|it| seed.episode(Purpose::Evaluation, it)));
        }
    }
    assert_eq!(trainer.evaluations(), 6);
    played.sort_unstable();
    expected.sort_unstable();
    assert_eq!(played, expected);
    expected.dedup();
    assert_eq!(expected.len(), 24 + 5, "no seed is both, and no training episode comes twice");
}

/// Episodes are logged for observers that want them, and a log holds all that happened.
#[test]
fn a_log_is_of_an_episode_that_was_wanted() {
    let mut config = config();
    config.env_steps = 8 * 25;
    let mut diary = Diary { wants_logs: true, ..Diary::default() };
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    trainer.run(None, &mut diary, &AtomicBool::new(false)).unwrap();
    let numbers: Vec<u64> = diary.logs.iter().map(|log| log.number).collect();
    assert_eq!(numbers, [1, 2, 4, 5, 7]);
    for log in &diary.logs {
        assert_eq!(log.seed, Seed(1).episode(Purpose::Environment, log.number));
        assert_eq!((log.actions.len(), log.decisions.len()), (3 * 25, 25));
        assert!(log.decisions.iter().all(|decision| decision.value.is_some()));
    }
}

/// Every second is spent on one thing, and what is saved is beside the loop.
#[test]
fn seconds_add_up() {
    let mut config = config();
    config.evaluation.every_episodes = 2;
    config.env_steps = 6 * 25;
    let folder = tempfile::tempdir().unwrap();
    let mut diary = Diary::default();
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    let started = Instant::now();
    trainer.run(Some(folder.path()), &mut diary, &AtomicBool::new(false)).unwrap();
    let elapsed = started.elapsed().as_secs_f64();
    let mut before = [0.0; 7];
    for Metrics { wall_s, time, .. } in &diary.metrics {
        let Seconds { environment, inference, relabel, update, evaluate, save } = *time;
        let parts = environment + inference + relabel + update + evaluate;
        assert!(parts <= *wall_s && wall_s + save <= elapsed, "{time:?} of {wall_s} s");
        let now = [*wall_s, environment, inference, relabel, update, evaluate, save];
        for (now, before) in now.iter().zip(before) {
            assert!(*now > before, "{time:?} after {before:?}");
        }
        before = now;
    }
}

/// A random action is kept for some steps, and then the step's own action is chosen.
#[test]
fn random_actions_are_kept() {
    let mut config = config();
    config.exploration.random_steps = 4.0;
    config.exploration.noise = 0.1;
    config.env_steps = 20 * 25;
    let mut diary = Diary { wants_logs: true, ..Diary::default() };
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    trainer.run(None, &mut diary, &AtomicBool::new(false)).unwrap();
    let (mut kept, mut renewed) = (0, 0);
    for log in &diary.logs {
        let actions: Vec<&[f32]> = log.actions.chunks_exact(3).collect();
        assert!(log.actions.iter().all(|number| number.abs() <= 1.0), "clamped");
        for step in 1..actions.len() {
            let same = actions[step] == actions[step - 1];
            let of_chance = |step: usize| log.decisions[step].source == ActionSource::Random;
            assert!(!same || of_chance(step) && of_chance(step - 1), "only chance repeats itself");
            if of_chance(step - 1) {
                if same { kept += 1 } else { renewed += 1 }
            }
        }
    }
    let share = f64::from(kept) / f64::from(kept + renewed);
    assert!((share - 0.75).abs() < 0.15, "kept {kept} times and not {renewed} times");
}
