//! Pictures of 320 by 240 pixels, by the simplest task and by the one with the most shapes.

use criterion::{Criterion, criterion_group, criterion_main};
use rher_core::env::EnvError;
use rher_envs::render::{Camera, Renderer, Viewpoint, scene};
use rher_envs::thing::Thing;
use rher_envs::{EnvVisitor, Simulated, Task};
use std::hint::black_box;
use std::num::NonZeroU16;

/// What there is to see as an episode begins.
struct Things;

impl EnvVisitor for Things {
    type Output = Result<(Camera, Vec<Thing>), EnvError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let start = env.reset(0, &mut observation)?;
        let camera = Viewpoint::Corner.camera(&mut env, &start)?;
        Ok((camera, scene(&mut env, &start.achieved, &start.desired)))
    }
}

fn pictures(criterion: &mut Criterion) {
    let size = [320, 240].map(|pixels| NonZeroU16::new(pixels).expect("not 0"));
    for task in [Task::REACH, Task::PUSH, Task::DRAWER_BOX] {
        let (camera, things) = task.visit(Things).expect("an episode begins");
        let mut renderer = Renderer::new(size);
        criterion.bench_function(&format!("render/{task}"), |bencher| {
            bencher.iter(|| black_box(renderer.draw(&camera, &things)));
        });
    }
}

criterion_group!(benches, pictures);
criterion_main!(benches);
