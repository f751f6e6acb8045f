//! Policy files.

use crate::toy::{Lines, Magnet, small};
use rher_core::env::Env as _;
use rher_core::episode::rollout;
use rher_core::goal::Stage;
use rher_core::policy::{Policy, PolicyError};
use rher_core::train::Trainer;
use std::sync::atomic::AtomicBool;

fn trained() -> Policy {
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
        let mut actor = policy.actor();
        let last = Stage::all().last().unwrap();
        rollout(&mut Magnet::<1>::new(), 3, |view, action| {
            actor.act(last, view.observation, view.achieved, view.desired, action);
        })
        .unwrap()
    };
    assert_eq!(act(&policy), act(&loaded));
    assert!(loaded.check(Magnet::<2>::new().spec()).is_err());
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
