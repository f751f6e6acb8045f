//! `rher bench env`: steps per CPU-second.

use crate::cli::BenchEnvArgs;
use crate::commands::{table, text};
use crate::observe::thousands;
use crate::printer::Printer;
use rand::RngExt as _;
use rher_core::env::Env;
use rher_core::seed::{Purpose, Seed};
use rher_envs::{EnvVisitor, Simulated, Task};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use std::time::Duration;

const WARM_UP: Duration = Duration::from_millis(200);
const MEASURED: Duration = Duration::from_secs(2);

/// What is printed of a task.
#[derive(Serialize)]
struct EnvSpeed {
    task: &'static str,
    /// Steps per second of CPU time, resets included.
    steps_per_cpu_s: f64,
    /// Microseconds of CPU time per reset.
    reset_us: f64,
}

pub(crate) fn bench_env(args: &BenchEnvArgs, printer: Printer) -> anyhow::Result<()> {
    let tasks = if args.tasks.is_empty() { Task::ALL } else { &args.tasks };
    let speeds = tasks
        .iter()
        .map(|&task| task.visit(Measure { task }))
        .collect::<anyhow::Result<Vec<EnvSpeed>>>()?;
    if args.json {
        printer.data(&serde_json::to_string_pretty(&speeds)?)?;
        return Ok(());
    }
    let mut listing = table();
    listing.set_header(["task", "steps per CPU-second", "reset (µs)"]);
    for EnvSpeed { task, steps_per_cpu_s, reset_us } in speeds {
        listing.add_row([
            task.to_owned(),
            thousands(steps_per_cpu_s as u64),
            format!("{reset_us:.0}"),
        ]);
    }
    printer.data(&text(&listing))?;
    Ok(())
}

struct Measure {
    task: Task,
}

impl EnvVisitor for Measure {
    type Output = anyhow::Result<EnvSpeed>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let mut env = build();
        play(&mut env, WARM_UP)?;
        let Spent { resets, resetting, steps, stepping } = play(&mut env, MEASURED)?;
        Ok(EnvSpeed {
            task: self.task.name(),
            steps_per_cpu_s: steps as f64 / (resetting + stepping).as_secs_f64(),
            reset_us: 1e6 * resetting.as_secs_f64() / resets as f64,
        })
    }
}

/// Where CPU time went.
#[derive(Default)]
struct Spent {
    resets: u64,
    resetting: Duration,
    steps: u64,
    stepping: Duration,
}

/// Plays whole episodes with random actions until `least` of CPU time is spent.
fn play<const N: usize>(env: &mut impl Env<N>, least: Duration) -> anyhow::Result<Spent> {
    let spec = env.spec().clone();
    let mut observation = vec![0.0; spec.observation];
    let mut actions = vec![0.0; spec.episode_steps * spec.action];
    let mut spent = Spent::default();
    while spent.resetting + spent.stepping < least {
        let mut rng = Seed(0).stream(Purpose::Exploration, spent.resets);
        actions.fill_with(|| rng.random_range(-1.0..=1.0));
        let started = cpu_time();
        env.reset(spent.resets, &mut observation)?;
        let ready = cpu_time();
        for action in actions.chunks_exact(spec.action) {
            env.step(action, &mut observation)?;
            spent.steps += 1;
        }
        spent.stepping += cpu_time().saturating_sub(ready);
        spent.resetting += ready.saturating_sub(started);
        spent.resets += 1;
    }
    Ok(spent)
}

/// CPU time of this thread, which is the only one that an environment uses.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.cast_unsigned(), time.tv_nsec as u32)
}
