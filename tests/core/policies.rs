//! Policy files.

use crate::toy::{Lines, Magnet, small};
use rher_core::config::Preset;
use rher_core::env::{Env as _, EnvSpec, Permutation, SignedIndex};
use rher_core::episode::{ActError, rollout};
use rher_core::goal::{Achieved, Desired, Position, Scene};
use rher_core::input::InputEncoder;
use rher_core::learner::state::LearnerState;
use rher_core::policy::{Actor, Policy, PolicyError, PolicyInfo};
use rher_core::seed::{Purpose, Seed};
use rher_core::train::Trainer;
use rher_core::{Control, Names};
use std::sync::atomic::AtomicBool;

pub(crate) fn trained() -> Policy {
    let mut config = small("magnet", 1);
    config.env_steps = 250;
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    trainer.run(None, &mut Lines::default(), &AtomicBool::new(false)).unwrap();
    trainer.policy().clone()
}

#[test]
fn a_policy_file_acts_as_the_policy_that_was_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    let policy = trained();
    policy.save(&path).unwrap();
    let loaded = Policy::load(&path).unwrap();
    assert_eq!(loaded, policy);
    assert_eq!(loaded.info().task, "magnet");
    let act = |policy: &Policy| {
        let mut env = Magnet::<1>::new();
        let mut actor = policy.actor(env.spec()).unwrap();
        rollout(&mut env, 3, |view, action| {
            actor.act(actor.task(), view.observation, view.achieved, view.desired, action)
        })
        .unwrap()
    };
    assert_eq!(act(&policy), act(&loaded));
}

#[test]
fn a_damaged_policy_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    trained().save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for length in [0, 7, 100, whole.len() - 1] {
        std::fs::write(&path, &whole[..length]).unwrap();
        let error = Policy::load(&path).unwrap_err();
        assert!(matches!(error, PolicyError::Malformed { .. }), "{length}: {error}");
    }
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(Policy::load(&path), Err(PolicyError::File(_))));
}

#[test]
fn every_flipped_bit_of_a_policy_file_is_noticed() {
    let mut config = small("magnet", 1);
    config.env_steps = 25;
    config.agent.hidden = vec![4];
    let mut trainer = Trainer::new(config, vec![Magnet::<1>::new()], 1).unwrap();
    trainer.run(None, &mut Lines::default(), &AtomicBool::new(false)).unwrap();
    let mut file = trainer.policy().to_bytes();
    assert_eq!(file, trainer.policy().to_bytes(), "equal policies have equal files");
    let path = "policy".as_ref();
    assert!(Policy::from_bytes(&file, path).is_ok());
    for bit in 0..8 * file.len() {
        file[bit / 8] ^= 1 << (bit % 8);
        assert!(Policy::from_bytes(&file, path).is_err(), "bit {bit}");
        file[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn metadata_that_describe_an_enormous_network_are_refused() {
    let file = trained().to_bytes();
    let text = String::from_utf8_lossy(&file).into_owned();
    assert!(text.contains("[32,32]"), "the widths of its layers");
    // Version 1 has no checksum, so what is wrong is seen by its size alone.
    for widths in ["[1000000000,1000000000]", "[9223372036854775808]", "[18446744073709551615]"] {
        let length = u64::from_le_bytes(*file.first_chunk().unwrap()) as usize;
        let header = String::from_utf8(file[8..8 + length].to_vec()).unwrap();
        let header = header
            .replace("hidden\\\":[32,32]", &format!("hidden\\\":{widths}"))
            .replace("version\\\":2", "version\\\":1");
        let mut changed = (header.len() as u64).to_le_bytes().to_vec();
        changed.extend(header.bytes());
        changed.extend(&file[8 + length..]);
        let error = Policy::from_bytes(&changed, "policy".as_ref()).unwrap_err();
        assert!(error.to_string().contains("a larger network than fits"), "{error}");
    }
}

#[test]
fn an_actor_for_another_scene_is_refused() {
    let policy = trained();
    let refused = |error: rher_core::policy::Mismatch| error.to_string();
    let fits = EnvSpec::<1>::new("arm", 4, 3, 25);
    assert!(policy.actor(&fits).is_ok());
    let two = policy.actor(&EnvSpec::<2>::new("arm", 4, 3, 25)).map(drop);
    assert_eq!(
        two.map_err(refused).unwrap_err(),
        "the policy does not fit the environment: objects is 1 in the policy and 2 in the environment"
    );
    let wide = policy.actor(&EnvSpec::<1>::new("arm", 5, 3, 25)).map(drop);
    assert!(wide.map_err(refused).unwrap_err().contains("obs_dim is 4 in the policy and 5"));
    let other_hand = policy.actor(&EnvSpec::<1>::new("arm", 4, 2, 25)).map(drop);
    assert!(other_hand.map_err(refused).unwrap_err().contains("action_dim is 3"));
}

#[test]
fn an_actor_refuses_what_is_not_finite_or_of_another_length() {
    let policy = trained();
    let mut actor = policy.actor(&EnvSpec::<1>::new("arm", 4, 3, 25)).unwrap();
    let here = Position::new(0.1, 0.2, 0.0);
    let scene = Achieved(Scene::new(here, [here]));
    let desired = Desired::of_task([Position::origin()]);
    let mut action = [0.0; 3];
    let mut act = |observation: &[f32], scene: &Achieved<1>, desired: &Desired<1>, width: usize| {
        actor.act(actor.task(), observation, scene, desired, &mut action[..width])
    };
    assert_eq!(act(&[0.0; 4], &scene, &desired, 3), Ok(()));
    let length = |field, expected, given| Err(ActError::Length { field, expected, given });
    assert_eq!(act(&[0.0; 3], &scene, &desired, 3), length("observation", 4, 3));
    assert_eq!(act(&[0.0; 9], &scene, &desired, 3), length("observation", 4, 9));
    assert_eq!(act(&[0.0; 4], &scene, &desired, 2), length("action", 3, 2));
    let said = |result: Result<(), ActError>| result.unwrap_err().to_string();
    assert_eq!(
        said(act(&[0.0, 0.0, f32::NAN, 0.0], &scene, &desired, 3)),
        "number 2 of `observation` is NaN, expected a finite number"
    );
    let mut lost = scene;
    lost.0.objects[0].y = f32::INFINITY;
    assert!(said(act(&[0.0; 4], &lost, &desired, 3)).contains("number 4 of `achieved` is inf"));
    let nowhere = Desired::of_task([Position::new(0.0, f32::NAN, 0.0)]);
    assert!(said(act(&[0.0; 4], &scene, &nowhere, 3)).contains("number 1 of `desired` is NaN"));
}

/// A policy of two objects that are alike, in order of turn; it was never trained.
fn of_two() -> Policy {
    let same = |from| SignedIndex { from, sign: 1.0, offset: 0.0 };
    let permutation = Permutation { order: [1, 0], observation: vec![same(1), same(0)] };
    let spec = EnvSpec::<2> { permutations: vec![permutation], ..EnvSpec::new("two", 2, 1, 5) };
    let config = Preset::Fast.config("two", 2);
    let encoder = InputEncoder::new(&config.relay, &spec);
    let mut rng = Seed(1).stream(Purpose::Init, 0);
    let learner = LearnerState::new(&config.agent, encoder.width(), 1, &mut rng);
    let info = PolicyInfo {
        task: spec.name.clone(),
        variant: String::new(),
        objects: 2,
        subtasks: 4,
        untrained: 0,
        obs_dim: 2,
        action_dim: 1,
        reach_distance: 0.03,
    };
    Policy::new(info, encoder, learner.actor.shape, learner.actor.online)
}

/// A controller holds its actor, and learns from the file how to wire it.
#[test]
fn a_policy_keeps_the_rate_the_units_and_the_names_of_its_numbers() {
    let list = |items: &[&str]| items.iter().map(ToString::to_string).collect();
    let mut spec = EnvSpec::<2>::new("two", 2, 1, 5);
    spec.names = Names {
        objects: list(&["block1", "block2"]),
        observation: list(&["block1.position.x", "block2.position.x"]),
        action: list(&["hand.x"]),
        tail: Vec::new(),
    };
    spec.control = Control {
        rate_hz: Some(25.0),
        frame: "x along the rail".to_owned(),
        observation_units: list(&["m", "m"]),
        action_units: list(&["0.05 m/step"]),
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    of_two().of_env(&spec).save(&path).unwrap();
    let policy = Policy::load(&path).unwrap();
    assert_eq!((policy.names(), policy.control()), (&spec.names, &spec.control));

    let scene = Achieved(Scene::new(Position::origin(), [Position::origin(); 2]));
    let desired = Desired::of_task([Position::new(0.1, 0.0, 0.0); 2]);
    let (mut lent, mut owned) = ([0.0], [0.0]);
    let mut actor = policy.actor(&spec).unwrap();
    actor.act(actor.task(), &[0.0; 2], &scene, &desired, &mut lent).unwrap();
    let mut actor: Actor<'static, 2> = policy.clone().into_actor(&spec).unwrap();
    actor.act(actor.task(), &[0.0; 2], &scene, &desired, &mut owned).unwrap();
    assert_eq!(lent, owned);
    assert_eq!(actor.policy(), &policy);

    spec.control.observation_units.pop();
    of_two().of_env(&spec).save(&path).unwrap();
    let error = Policy::load(&path).unwrap_err().to_string();
    assert!(error.contains("`control.observation_units` has 1 units, expected 2"), "{error}");
    spec.control.rate_hz = Some(0.0);
    let error = spec.validate().unwrap_err().to_string();
    assert!(error.contains("`control.rate_hz` = 0, expected a number of actions"), "{error}");
}

/// What a file says of the order of objects is not trusted either: it would index an observation.
#[test]
fn an_order_of_objects_that_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    let policy = of_two();
    policy.save(&path).unwrap();
    assert_eq!(Policy::load(&path).unwrap(), policy);
    let whole = std::fs::read(&path).unwrap();
    // The description is JSON within JSON; spaces keep its length. Version 1 has no checksum.
    let version = whole.windows(11).position(|bytes| bytes == br#"version\":2"#).unwrap();
    let second = r#"{\"from\":1,\"sign\":1.0,\"offset\":0.0}"#;
    for (text, other) in [
        (second.to_owned(), second.replace("1,", "2,")),
        (second.to_owned(), second.replace("1,", "9,")),
        (format!(",{second}"), String::new()),
        (r"[0.05,0.05]".to_owned(), "[0.05]".to_owned()),
    ] {
        let at = whole.windows(text.len()).position(|bytes| bytes == text.as_bytes()).unwrap();
        let mut file = whole.clone();
        file[version + 10] = b'1';
        let padded = format!("{other:width$}", width = text.len());
        file[at..at + text.len()].copy_from_slice(padded.as_bytes());
        std::fs::write(&path, file).unwrap();
        let error = Policy::load(&path).unwrap_err().to_string();
        assert!(error.contains("the order of its objects does not fit"), "{text}: {error}");
    }
}
