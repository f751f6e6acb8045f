//! CPU time of an environment step with random actions, and of a reset.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

use cpu_time::ThreadTime;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_envs::{EnvVisitor, Simulated, Task};
use std::time::Duration;

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = every_task
}
criterion_main!(benches);

fn every_task(criterion: &mut Criterion<CpuTime>) {
    for task in Task::ALL {
        task.visit(Bench { task: *task, criterion });
    }
}

struct Bench<'a> {
    task: Task,
    criterion: &'a mut Criterion<CpuTime>,
}

impl EnvVisitor for Bench<'_> {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let mut action = vec![0.0; env.spec().action_dim];
        let episode_steps = env.spec().episode_steps;
        let mut rng = ChaCha8Rng::seed_from_u64(1);

        let mut group = self.criterion.benchmark_group("env");
        group.throughput(Throughput::Elements(1));
        let mut step = 0;
        group.bench_function(format!("step/{}", self.task), |bencher| {
            bencher.iter(|| {
                if step % episode_steps == 0 {
                    env.reset(step as u64, &mut observation).unwrap();
                }
                step += 1;
                action.fill_with(|| rng.random_range(-1.0..1.0));
                env.step(&action, &mut observation).unwrap()
            });
        });
        let mut seed = 0;
        group.bench_function(format!("reset/{}", self.task), |bencher| {
            bencher.iter(|| {
                seed += 1;
                env.reset(seed, &mut observation).unwrap()
            });
        });
        group.finish();
    }
}

/// CPU time of this thread: other work on the machine does not count.
struct CpuTime;

impl Measurement for CpuTime {
    type Intermediate = ThreadTime;
    type Value = Duration;

    fn start(&self) -> ThreadTime {
        ThreadTime::now()
    }

    fn end(&self, start: ThreadTime) -> Duration {
        start.elapsed()
    }

    fn add(&self, a: &Duration, b: &Duration) -> Duration {
        *a + *b
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        WallTime.to_f64(value)
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}
