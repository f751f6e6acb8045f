//! Pictures of 320 by 240 pixels, by the simplest task and by the one with the most shapes.

use criterion::{Criterion, criterion_group, criterion_main};
use rher_envs::render::{Camera, Renderer};
use rher_envs::thing::Thing;
use rher_envs::{EnvVisitor, Simulated, Task};
use std::hint::black_box;
use std::num::NonZeroU16;

struct Things;

impl EnvVisitor for Things {
    type Output = Vec<Thing>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Vec<Thing> {
        build().things()
    }
}

fn pictures(criterion: &mut Criterion) {
    let size = [320, 240].map(|pixels| NonZeroU16::new(pixels).expect("not 0"));
    for task in [Task::REACH, Task::PUSH, Task::DRAWER_BOX] {
        let things = task.visit(Things);
        let camera = Camera::above_table(&things);
        let mut renderer = Renderer::new(size);
        criterion.bench_function(&format!("render/{task}"), |bencher| {
            bencher.iter(|| black_box(renderer.draw(&camera, &things)));
        });
    }
}

criterion_group!(benches, pictures);
criterion_main!(benches);
