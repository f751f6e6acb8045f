//! Time of drawing, relabeling and normalizing a batch: `relabel/256` draws 256 rows.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::Preset;
use rher_core::env::{End, EnvSpec, Mirror, SignedIndex};
use rher_core::episode::Episode;
use rher_core::goal::{Achieved, Desired, Position, Scene, Stage, Tolerances};
use rher_core::input::InputEncoder;
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use rher_core::{Control, Names};

const OBSERVATION: usize = 25;
const ACTION: usize = 4;
const STEPS: usize = 50;
const EPISODES: usize = 20_000;
const ROWS: usize = 256;

fn spec() -> EnvSpec<1> {
    let same = |from| SignedIndex { from, sign: 1.0, offset: 0.0 };
    EnvSpec {
        name: "bench".to_owned(),
        variant: String::new(),
        obs_dim: OBSERVATION,
        action_dim: ACTION,
        episode_steps: STEPS,
        subtasks: 2,
        tolerances: Tolerances::uniform(0.05),
        mirrors: vec![Mirror {
            axis: 1,
            center: 0.0,
            observation: (0..OBSERVATION).map(same).collect(),
            action: (0..ACTION).map(same).collect(),
            tail: Vec::new(),
        }],
        permutations: Vec::new(),
        any_order: false,
        names: Names::default(),
        control: Control::default(),
    }
}

fn episode(rng: &mut ChaCha8Rng) -> Episode<1> {
    let mut numbers = |count: usize| (0..count).map(|_| rng.random::<f32>()).collect::<Vec<_>>();
    let observations = numbers((STEPS + 1) * OBSERVATION);
    let actions = numbers(STEPS * ACTION);
    let mut place = || Position::from([rng.random(), rng.random(), rng.random()]);
    let desired = Desired::of_task([place()]);
    let achieved = (0..=STEPS).map(|_| Achieved(Scene::new(place(), [place()]))).collect();
    Episode { desired, observations, achieved, actions, end: End::Truncated }
}

fn relabel(criterion: &mut Criterion) {
    let spec = spec();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut replay = Replay::new(&spec, EPISODES * STEPS);
    for _ in 0..EPISODES {
        replay.push(&episode(&mut rng));
    }
    let config = Preset::Fast.config("bench", 1).relay;
    let mut relabeler = Relabeler::new(&config, &spec);
    let encoder = InputEncoder::new(&config, &spec);
    let mut batch = Batch::zeros(ROWS, encoder.width(), ACTION);
    let last = Stage::all().last().expect("a task has a stage");

    let mut group = criterion.benchmark_group("relabel");
    group.throughput(Throughput::Elements(ROWS as u64));
    group.bench_function(ROWS.to_string(), |bencher| {
        bencher.iter(|| relabeler.draw(&replay, &encoder, last, &mut batch, 0..ROWS, &mut rng));
    });
    group.finish();
}

criterion_group!(benches, relabel);
criterion_main!(benches);
