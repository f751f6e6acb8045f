//! One update: 31 numbers in, three layers of 256, 4 out, for the two batch sizes of the paper.

use criterion::{Criterion, criterion_group, criterion_main};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::agent::burn::BurnEngine;
use rher_core::agent::config::{AgentConfig, EngineKind, Init, TargetEvery};
use rher_core::agent::learner::{Engine as _, LearnerState};
use rher_core::batch::Batch;

fn update(criterion: &mut Criterion) {
    let td3 = AgentConfig {
        engine: EngineKind::Burn,
        hidden: vec![256; 3],
        init: Init::FanIn,
        critics: 2,
        critic_layer_norm: false,
        policy_delay: 2,
        target_noise: 0.2,
        target_noise_clip: 0.5,
        discount: 0.98,
        action_l2: 1.0,
        actor_learning_rate: 1e-3,
        critic_learning_rate: 1e-3,
        target_rate: 0.05,
        target_every: TargetEvery::Update,
    };
    let ddpg = AgentConfig { critics: 1, policy_delay: 1, target_noise: 0.0, ..td3.clone() };
    let mut group = criterion.benchmark_group("update");
    group.sample_size(10);
    for (name, config) in [("ddpg", ddpg), ("td3", td3)] {
        for rows in [256, 2048] {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let mut batch = Batch::zeros(rows, 31, 4);
            batch.rewards.fill(-1.0);
            for numbers in [&mut batch.inputs, &mut batch.next_inputs, &mut batch.actions] {
                numbers.fill_with(|| rng.random_range(-1.0..1.0));
            }
            let noise: Vec<f32> = (0..rows * 4).map(|_| rng.random_range(-2.0..2.0)).collect();
            let state = LearnerState::new(&config, 31, 4, &mut rng);
            let mut engine = BurnEngine::from_state(&config, state);
            // Two, so that every sample holds as many updates of the actor.
            group.bench_function(format!("burn/{name}/{rows}/two"), |bencher| {
                bencher.iter(|| [(); 2].map(|()| engine.update(&batch, &noise)));
            });
        }
    }
}

criterion_group!(benches, update);
criterion_main!(benches);
