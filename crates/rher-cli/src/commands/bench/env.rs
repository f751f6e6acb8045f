//! `rher bench env`: steps per CPU-second.

use crate::cli::BenchEnvArgs;
use crate::host::Again;
use crate::host::threads;
use crate::numbers::thousands;
use crate::printer::Printer;
use crate::tables::{table, text};
use anyhow::Context as _;
use cpu_time::ThreadTime;
use rand::RngExt as _;
use rher_core::env::Env;
use rher_core::seed::{Purpose, Seed};
use rher_envs::{AutoReset, EnvVisitor, Pool, SUBSTEPS, Simulated, Task};
use serde::Serialize;
use std::process::Stdio;
use std::time::{Duration, Instant};

const WARM_UP: Duration = Duration::from_millis(200);
const MEASURED: Duration = Duration::from_secs(2);

/// Environments that are stepped together.
const TOGETHER: usize = 256;

/// Times that each way of stepping them is measured, in turn; the best counts, since whatever else
/// the machine does only slows it.
const ROUNDS: usize = 5;

/// How long each of these takes.
const ROUND: Duration = Duration::from_millis(500);

/// Steps before that, in which environments allocate what they need.
const WARM_UP_STEPS: usize = 10;

/// What is printed of a task.
#[derive(Serialize)]
struct EnvSpeed {
    task: &'static str,
    /// Collision detections in a step, and solver substeps in each.
    substeps: [u8; 2],
    /// Steps per second of CPU time, resets included.
    steps_per_cpu_s: f64,
    /// Microseconds of CPU time per reset.
    reset_us: f64,
    /// Only for tasks that were asked for by name, and for the one that stands for all.
    together: Option<TogetherSpeed>,
}

/// Steps per second on the wall of many environments together, resets included.
#[derive(Serialize)]
struct TogetherSpeed {
    envs: usize,
    threads: usize,
    one_thread: f64,
    all_threads: f64,
    /// As many processes as threads, each with one thread and as many environments.
    processes: f64,
}

pub(crate) fn bench_env(
    args: &BenchEnvArgs,
    again: &Again,
    printer: Printer,
) -> anyhow::Result<()> {
    if args.one_thread {
        for task in &args.tasks {
            printer.data(&task.visit(Together { threads: 1 })?.to_string())?;
        }
        return Ok(());
    }
    let tasks = if args.tasks.is_empty() { Task::ALL } else { &args.tasks };
    let stands_for_all = |task| task == Task::PUSH;
    let speeds = tasks
        .iter()
        .map(|&task| {
            let mut speed = task.visit(Measure { task })?;
            if !args.tasks.is_empty() || stands_for_all(task) {
                speed.together = Some(together(task, again)?);
            }
            Ok(speed)
        })
        .collect::<anyhow::Result<Vec<EnvSpeed>>>()?;
    if args.json {
        printer.data(&serde_json::to_string_pretty(&speeds)?)?;
        return Ok(());
    }
    let mut listing = table();
    listing.set_header(["task", "substeps", "steps per CPU-second", "reset (µs)"]);
    for EnvSpeed { task, substeps: [detections, solver], steps_per_cpu_s, reset_us, .. } in &speeds
    {
        listing.add_row([
            (*task).to_owned(),
            format!("{detections} × {solver}"),
            thousands(*steps_per_cpu_s as u64),
            format!("{reset_us:.0}"),
        ]);
    }
    printer.data(&text(&listing))?;
    for EnvSpeed { task, together, .. } in &speeds {
        if let Some(together) = together {
            printer.data(&describe(task, together))?;
        }
    }
    Ok(())
}

fn describe(task: &str, together: &TogetherSpeed) -> String {
    let TogetherSpeed { envs, threads, one_thread, all_threads, processes } = together;
    let mut listing = table();
    listing.set_header([&format!("{envs} × {task}"), "steps per second", "of one thread"]);
    for (name, rate) in [
        ("1 thread".to_owned(), one_thread),
        (format!("{threads} threads"), all_threads),
        (format!("{threads} processes"), processes),
    ] {
        let share = format!("{:.2}", rate / one_thread);
        listing.add_row([name, thousands(*rate as u64), share]);
    }
    format!("\n{}", text(&listing))
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
            substeps: SUBSTEPS,
            steps_per_cpu_s: steps as f64 / (resetting + stepping).as_secs_f64(),
            reset_us: 1e6 * resetting.as_secs_f64() / resets as f64,
            together: None,
        })
    }
}

/// Measures the three ways of stepping many environments, in turn.
fn together(task: Task, again: &Again) -> anyhow::Result<TogetherSpeed> {
    let threads = threads(None);
    let (mut one_thread, mut all_threads, mut processes) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..ROUNDS {
        one_thread = one_thread.max(task.visit(Together { threads: 1 })?);
        all_threads = all_threads.max(task.visit(Together { threads })?);
        processes = processes.max(in_processes(task, threads, again)?);
    }
    Ok(TogetherSpeed { envs: TOGETHER, threads, one_thread, all_threads, processes })
}

/// The sum of what this program reaches when it runs several times at once, each on one thread.
fn in_processes(task: Task, processes: usize, again: &Again) -> anyhow::Result<f64> {
    let start = |_| {
        again
            .command()
            .args(["bench", "env", "--one-thread", "--task", task.name()])
            .stdout(Stdio::piped())
            .spawn()
    };
    let started = (0..processes).map(start).collect::<Result<Vec<_>, _>>()?;
    let mut rate = 0.0;
    for process in started {
        let output = process.wait_with_output()?;
        let printed = String::from_utf8(output.stdout)?;
        rate += printed.trim().parse::<f64>().with_context(|| {
            format!("a process of its own printed `{}`, expected a number", printed.trim())
        })?;
    }
    Ok(rate)
}

/// Steps many environments with random actions, and counts steps per second.
struct Together {
    threads: usize,
}

impl EnvVisitor for Together {
    type Output = anyhow::Result<f64>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let envs = (0..TOGETHER).map(|_| build()).collect();
        let mut pool = Pool::new(envs, self.threads, AutoReset::SameStep)?;
        let seeds: Vec<u64> = (0..TOGETHER as u64).collect();
        pool.reset(&seeds)?;
        let mut rng = Seed(0).stream(Purpose::Exploration, 0);
        let mut actions = vec![0.0; TOGETHER * pool.spec().action_dim];
        for _ in 0..WARM_UP_STEPS {
            pool.step(&actions)?;
        }
        let started = Instant::now();
        let mut steps = 0;
        while started.elapsed() < ROUND {
            actions.fill_with(|| rng.random_range(-1.0..=1.0));
            pool.step(&actions)?;
            steps += TOGETHER;
        }
        Ok(steps as f64 / started.elapsed().as_secs_f64())
    }
}

/// Where the CPU time of this thread went, which is the only one that an environment uses.
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
    let mut observation = vec![0.0; spec.obs_dim];
    let mut actions = vec![0.0; spec.episode_steps * spec.action_dim];
    let mut spent = Spent::default();
    while spent.resetting + spent.stepping < least {
        let mut rng = Seed(0).stream(Purpose::Exploration, spent.resets);
        actions.fill_with(|| rng.random_range(-1.0..=1.0));
        let started = ThreadTime::now();
        env.reset(spent.resets, &mut observation)?;
        spent.resetting += started.elapsed();
        let ready = ThreadTime::now();
        for action in actions.chunks_exact(spec.action_dim) {
            env.step(action, &mut observation)?;
            spent.steps += 1;
        }
        spent.stepping += ready.elapsed();
        spent.resets += 1;
    }
    Ok(spent)
}
