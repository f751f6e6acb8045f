//! A run that starts from another one.

use crate::toy::{Lines, Magnet, small};
use rher_core::config::{GoalFrame, Method, ObjectOrder, StartedFrom, TrainConfig};
use rher_core::event::{Event, Metrics, Observer, ObserverError, Seconds};
use rher_core::train::checkpoint::read_critic;
use rher_core::train::{Finish, PretrainedError, TrainError, Unfit};
use rher_core::{Achieved, Env, EnvError, EnvSpec, Names, Pretrained, Start, Trainer};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::TempDir;

/// Names of a [`Magnet`] whose objects are of this kind, moved by this hand.
fn names(objects: usize, kind: &str, hand: &str) -> Names {
    let objects: Vec<String> = (1..=objects).map(|number| format!("{kind}{number}")).collect();
    let places = ["gripper"].into_iter().chain(objects.iter().map(String::as_str));
    let observation =
        places.flat_map(|owner| ["x", "y"].map(|axis| format!("{owner}.position.{axis}")));
    Names {
        observation: observation.collect(),
        action: ["x", "y", "grip"].map(|what| format!("{hand}.{what}")).into(),
        objects,
        tail: Vec::new(),
    }
}

fn config(objects: usize) -> TrainConfig {
    let mut config = small("magnet", objects);
    config.agent.hidden = vec![8, 8];
    config.agent.critics = 2;
    // The same, however many objects there are.
    config.agent.critic_layer_norm = false;
    config.replay.batch_size = 8;
    config.replay.updates_per_episode = 3;
    config.evaluation.episodes = 4;
    config.evaluation.subtask_episodes = 2;
    config.env_steps = 20 * 25;
    config
}

/// A [`Magnet`] whose numbers have names.
struct Called<const N: usize>(Magnet<N>, EnvSpec<N>);

impl<const N: usize> Env<N> for Called<N> {
    fn spec(&self) -> &EnvSpec<N> {
        &self.1
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        self.0.reset(seed, observation)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        self.0.step(action, observation)
    }
}

fn envs<const N: usize>(names: &Names) -> Vec<Called<N>> {
    let magnet = Magnet::new();
    let spec = EnvSpec { names: names.clone(), ..magnet.spec().clone() };
    vec![Called(magnet, spec)]
}

/// Trains a run with these settings in a folder.
fn trained<const N: usize>(config: TrainConfig) -> TempDir {
    let folder = TempDir::new().unwrap();
    let mut trainer = Trainer::new(config, envs::<N>(&Names::default()), 1).unwrap();
    trainer.run(Some(folder.path()), &mut Lines::default(), &AtomicBool::new(false)).unwrap();
    folder
}

fn blocks(objects: usize) -> Names {
    names(objects, "block", "hand")
}

/// A run with these settings from the one in `folder`.
fn from<const N: usize>(
    folder: &Path,
    known: &Names,
    config: TrainConfig,
    new: &Names,
) -> Result<Trainer<N, Called<N>>, TrainError> {
    let pretrained = Pretrained::read(folder, |_| known.clone())?;
    Trainer::new_from(&pretrained, config, envs::<N>(new), 1)
}

#[test]
fn a_run_of_the_same_task_starts_with_the_same_networks() {
    let source = trained::<2>(config(2));
    let trainer = Trainer::resume(source.path(), envs::<2>(&Names::default()), 1).unwrap();
    for known in [blocks(2), Names::default()] {
        let mut new = from::<2>(source.path(), &known, config(2), &known).unwrap();
        let expected = trainer.policy().clone().of_env(new.spec());
        assert_eq!(new.policy().clone().of_run(trainer.id()), expected);
        assert_eq!((new.progress().episodes, new.progress().updates), (0, 0));
        let copy = TempDir::new().unwrap();
        new.save(copy.path()).unwrap();
        assert_eq!(read_critic(copy.path()).unwrap(), read_critic(source.path()).unwrap());
    }
}

#[test]
fn where_a_run_started_is_part_of_what_it_is() {
    let source = trained::<1>(config(1));
    let first = Trainer::resume(source.path(), envs::<1>(&Names::default()), 1).unwrap();
    let new = from::<2>(source.path(), &blocks(1), config(2), &blocks(2)).unwrap();
    let updates = first.progress().updates;
    let expected = StartedFrom { task: "magnet".to_owned(), run: first.id(), updates };
    assert_eq!(new.config().from, Some(expected));

    let alone = Trainer::new(config(2), envs::<2>(&blocks(2)), 1).unwrap();
    assert_ne!(new.id(), alone.id());
    assert_ne!(new.policy().to_bytes(), alone.policy().to_bytes());
    // Settings alone do not start a run from another one.
    let again = Trainer::new(new.config().clone(), envs::<2>(&blocks(2)), 1).unwrap();
    assert_eq!((again.id(), &again.config().from), (alone.id(), &None));
}

/// Sets the flag after some episodes.
struct StopAfter<'a>(u64, &'a AtomicBool, Lines);

impl Observer for StopAfter<'_> {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        if let Event::Progress(progress) = event
            && progress.episodes >= self.0
        {
            self.1.store(true, Ordering::Relaxed);
        }
        self.2.on(event)
    }
}

#[test]
fn resuming_it_needs_no_other_run_and_changes_nothing() {
    let source = trained::<1>(config(1));
    let start = || from::<2>(source.path(), &blocks(1), config(2), &blocks(2)).unwrap();
    let timeless = |lines: Lines| -> Vec<Metrics> {
        let timeless = |metrics| Metrics { wall_s: 0.0, time: Seconds::default(), ..metrics };
        lines.0.into_iter().map(timeless).collect()
    };
    let run = |trainer: &mut Trainer<2, Called<2>>, folder: &Path, episodes| {
        let stop = AtomicBool::new(false);
        let mut observer = StopAfter(episodes, &stop, Lines::default());
        let finish = trainer.run(Some(folder), &mut observer, &stop).unwrap();
        (finish, timeless(observer.2))
    };
    let [straight, stopped] = [(); 2].map(|()| TempDir::new().unwrap());
    let mut uninterrupted = start();
    let (_, expected) = run(&mut uninterrupted, straight.path(), u64::MAX);

    let mut first = start();
    let (finish, mut lines) = run(&mut first, stopped.path(), 7);
    assert_eq!(finish, Finish::Stopped);
    drop(source);
    let mut rest = Trainer::resume(stopped.path(), envs::<2>(&blocks(2)), 1).unwrap();
    assert_eq!((rest.id(), &rest.config().from), (first.id(), &first.config().from));
    lines.extend(run(&mut rest, stopped.path(), u64::MAX).1);
    assert_eq!(lines, expected);
    assert!(expected.iter().any(|line| line.updates > 0));
    assert_eq!(rest.policy(), uninterrupted.policy());
    let critic = |folder: &TempDir| read_critic(folder.path()).unwrap();
    assert_eq!(critic(&stopped), critic(&straight));
}

/// Why a run of 2 objects cannot start from `folder`.
fn reason(
    folder: &Path,
    known: &Names,
    new: &Names,
    change: impl FnOnce(&mut TrainConfig),
) -> Unfit {
    let mut config = config(2);
    change(&mut config);
    match from::<2>(folder, known, config, new).map(drop) {
        Err(TrainError::Pretrained(error @ PretrainedError::Unfit { .. })) => {
            let text = error.to_string();
            assert!(text.contains(&folder.display().to_string()), "{text}");
            assert!(text.contains("expected"), "{text}");
            let PretrainedError::Unfit { reason, .. } = error else { unreachable!() };
            reason
        }
        other => panic!("{other:?}"),
    }
}

fn nothing(_: &mut TrainConfig) {}

#[test]
fn another_kind_of_task_is_refused() {
    let one = trained::<1>(config(1));
    let one = one.path();
    let puck = names(1, "puck", "hand");
    let other_object =
        Unfit::OtherObject { number: 1, found: "puck1".to_owned(), expected: "block1".to_owned() };
    assert_eq!(reason(one, &puck, &blocks(2), nothing), other_object);

    let claw = names(1, "block", "claw");
    let other_hand = Unfit::OtherHand {
        found: "claw.x, claw.y, claw.grip".to_owned(),
        expected: "hand.x, hand.y, hand.grip".to_owned(),
    };
    assert_eq!(reason(one, &claw, &blocks(2), nothing), other_hand);

    let three = trained::<3>(config(3));
    let more = Unfit::MoreObjects { found: 3, expected: 2 };
    assert_eq!(reason(three.path(), &blocks(3), &blocks(2), nothing), more);
    assert_eq!(reason(three.path(), &Names::default(), &Names::default(), nothing), more);
}

#[test]
fn without_names_only_equal_dimensions_fit() {
    let none = Names::default();
    let (one, two) = (trained::<1>(config(1)), trained::<2>(config(2)));
    assert!(from::<2>(two.path(), &none, config(2), &none).is_ok());
    let unnamed = |folder: &TempDir, known: &Names, new: &Names| {
        let reason = reason(folder.path(), known, new, nothing);
        assert!(matches!(reason, Unfit::Unnamed { .. }), "{reason:?}");
    };
    unnamed(&one, &none, &none);
    unnamed(&two, &none, &blocks(2));
    unnamed(&two, &blocks(2), &none);
    // Names that are those of something else.
    unnamed(&two, &blocks(1), &blocks(2));
}

#[test]
fn networks_and_inputs_of_another_form_are_refused() {
    type Change = fn(&mut TrainConfig);
    let changes: [(&str, [&str; 2], Change); 6] = [
        ("agent.hidden", ["[8,8]", "[8]"], |config| config.agent.hidden = vec![8]),
        ("agent.hidden", ["[8,8]", "[8,9]"], |config| config.agent.hidden = vec![8, 9]),
        ("agent.critics", ["2", "1"], |config| config.agent.critics = 1),
        ("agent.critic_layer_norm", ["false", "true"], |config| {
            config.agent.critic_layer_norm = true;
        }),
        ("relay.goal_frame", ["relative", "absolute"], |config| {
            config.relay.goal_frame = GoalFrame::Absolute;
        }),
        ("relay.object_order", ["turn", "relay"], |config| {
            config.relay.object_order = ObjectOrder::Relay;
        }),
    ];
    let source = trained::<1>(config(1));
    for (key, [found, expected], change) in changes {
        let found = found.to_owned();
        let expected = Unfit::OtherSetting { key, found, expected: expected.to_owned() };
        assert_eq!(reason(source.path(), &blocks(1), &blocks(2), change), expected);
    }
}

#[test]
fn a_run_that_has_nothing_to_give_is_refused() {
    let known = blocks(1);
    let plain = trained::<1>({
        let mut config = config(1);
        config.relay.method = Method::Her;
        config
    });
    assert_eq!(reason(plain.path(), &known, &blocks(2), nothing), Unfit::PlainHindsight);

    let untrained = trained::<1>({
        let mut config = config(1);
        config.replay.warmup_episodes = 1000;
        config
    });
    assert_eq!(reason(untrained.path(), &known, &blocks(2), nothing), Unfit::Untrained);

    let source = trained::<1>(config(1));
    let plain = |config: &mut TrainConfig| config.relay.method = Method::Her;
    assert_eq!(reason(source.path(), &known, &blocks(2), plain), Unfit::ForPlainHindsight);

    let empty = TempDir::new().unwrap();
    let policy = source.path().join("policy.safetensors");
    for path in [empty.path(), &empty.path().join("nowhere"), &policy] {
        let error = Pretrained::read(path, |_| Names::default()).unwrap_err();
        assert!(matches!(&error, PretrainedError::NoCheckpoint { folder } if folder == path));
    }
    std::fs::write(source.path().join("checkpoint/current.ckpt"), "RHERCKPT").unwrap();
    let error = Pretrained::read(source.path(), |_| known).unwrap_err();
    assert!(matches!(error, PretrainedError::Checkpoint(_)), "{error}");
}
