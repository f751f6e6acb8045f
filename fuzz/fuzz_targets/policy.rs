//! A policy file is a policy that acts, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rher_core::{Achieved, Desired, EnvSpec, Policy, Position, Scene};
use std::path::Path;

fuzz_target!(|file: &[u8]| {
    // The checksum of version 2 would keep out almost everything; version 1 has none.
    if let Ok(policy) = Policy::from_bytes(file, Path::new("policy")) {
        let info = policy.info().clone();
        if info.objects == 1 {
            let mut spec = EnvSpec::<1>::new("fuzz", info.obs_dim, info.action_dim, 1);
            spec.tolerances.tail = *policy.tail();
            let Ok(mut actor) = policy.actor(&spec) else { return };
            let observation = vec![0.0; info.obs_dim];
            let mut action = vec![0.0; info.action_dim];
            let place = Position::new(0.1, 0.2, 0.3);
            let scene = Achieved(Scene::new(place, [place]));
            let desired = Desired::of_task([place]);
            let _ = actor.act(actor.task(), &observation, &scene, &desired, &mut action);
        }
        assert!(Policy::from_bytes(&policy.to_bytes(), Path::new("again")).unwrap() == policy);
    }
});
