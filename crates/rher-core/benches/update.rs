//! Time of one update of the learner, by engine, batch, inputs and threads.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::ThreadPoolBuilder;
use rher_core::batch::Batch;
use rher_core::config::{AgentConfig, EngineKind};
use rher_core::learner::engines;
use rher_core::learner::state::LearnerState;
use rher_core::normal::StandardNormal;

const ACTION: usize = 4;

fn draw_batch(rows: usize, input: usize, rng: &mut ChaCha8Rng) -> Batch {
    let mut batch = Batch::zeros(rows, input, ACTION);
    batch.inputs.fill_with(|| rng.sample(StandardNormal));
    batch.next_inputs.fill_with(|| rng.sample(StandardNormal));
    batch.actions.fill_with(|| rng.random_range(-1.0..1.0));
    batch.rewards.fill_with(|| -f32::from(rng.random_bool(0.9)));
    batch
}

fn update(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("update");
    for kind in [EngineKind::Fused, EngineKind::Burn] {
        for threads in [1, 2] {
            for input in [31, 81] {
                for rows in [128, 256, 1024, 2048] {
                    let mut rng = ChaCha8Rng::seed_from_u64(0);
                    let config = AgentConfig {
                        engine: kind,
                        hidden: vec![256; 3],
                        imitation: 1.0,
                        ..AgentConfig::td3()
                    };
                    let state = LearnerState::new(&config, input, ACTION, &mut rng);
                    let mut learner =
                        engines::build(&config, state).expect("both engines are compiled in");
                    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
                    let pool = pool.expect("threads can be started");
                    let batch = draw_batch(rows, input, &mut rng);
                    let mut noise = vec![0.0; rows * ACTION];
                    noise.fill_with(|| rng.sample(StandardNormal));
                    let id = BenchmarkId::new(kind.name(), format!("{rows}x{input}/{threads}"));
                    group.bench_function(id, |bencher| {
                        // A mean over updates with and without the actor.
                        pool.install(|| {
                            bencher
                                .iter(|| learner.update(&batch, &noise).expect("finite gradients"));
                        });
                    });
                }
            }
        }
    }
}

criterion_group!(benches, update);
criterion_main!(benches);
