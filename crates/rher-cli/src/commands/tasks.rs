//! `rher tasks`: what can be learned.

use crate::cli::TasksArgs;
use crate::numbers::{percent, range_of_steps};
use crate::printer::Printer;
use crate::published::{Published, PublishedRun};
use rher_core::goal::EncodedGoal;
use rher_envs::{EnvVisitor, Simulated, Task};
use serde::Serialize;

/// Success rate at which runs end by default.
const USUAL_RATE: f32 = 0.95;

/// What holds for every episode of a task.
#[derive(Serialize)]
struct TaskFacts {
    name: String,
    /// What there is to do, in a sentence.
    about: &'static str,
    objects: usize,
    /// Runs of the preset `fast` that were solved, and when; `null` where none is published.
    solved: Option<Solved>,
    subtasks: usize,
    observation: usize,
    action: usize,
    /// Numbers of a goal in Gymnasium: one position for each object.
    goal: usize,
    /// Numbers of a goal as networks see it: the gripper's slot and one for each object.
    encoded_goal: usize,
    episode_steps: usize,
    /// By slot, in meters.
    tolerance: Vec<f32>,
    /// What each object is; tasks of which one can start from a run of the other have the same.
    object_names: Vec<String>,
    observation_names: Vec<String>,
    action_names: Vec<String>,
}

/// Published runs that were solved.
#[derive(Serialize)]
struct Solved {
    /// Success rate in two consecutive evaluations at which they ended.
    until: f32,
    runs: Vec<End>,
}

#[derive(Serialize)]
struct End {
    env_steps: u64,
    /// Seconds on one core.
    wall_s: u64,
}

struct Describe(Task);

impl EnvVisitor for Describe {
    type Output = TaskFacts;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> TaskFacts {
        let env = build();
        let spec = env.spec();
        let names = spec.names.clone();
        let end = |run: PublishedRun| End { env_steps: run.env_steps(), wall_s: run.wall_s };
        let solved = Published::of(self.0.name()).map(|Published { until, runs }| {
            let runs = runs.into_iter().map(end).collect();
            Solved { until, runs }
        });
        TaskFacts {
            name: spec.name.clone(),
            about: self.0.about(),
            objects: N,
            solved,
            subtasks: spec.subtasks,
            observation: spec.obs_dim,
            action: spec.action_dim,
            goal: 3 * N,
            encoded_goal: 3 * EncodedGoal::<N>::SLOTS,
            episode_steps: spec.episode_steps,
            tolerance: spec.tolerances.by_slot().collect(),
            object_names: names.objects,
            observation_names: names.observation,
            action_names: names.action,
        }
    }
}

pub(crate) fn tasks(args: &TasksArgs, printer: Printer) -> anyhow::Result<()> {
    let facts: Vec<TaskFacts> =
        Task::all().into_iter().map(|task| task.visit(Describe(task))).collect();
    if args.json {
        printer.data(&serde_json::to_string_pretty(&facts)?)?;
        return Ok(());
    }
    let width = facts.iter().map(|task| task.name.len()).max().unwrap_or(0) + 2;
    let describe = |TaskFacts { name, about, solved, .. }: &TaskFacts| {
        let takes = solved.as_ref().map(|solved| format!("{:width$}{}\n", "", takes(solved)));
        format!("{name:width$}{about}\n{}", takes.unwrap_or_default())
    };
    printer.data(&facts.iter().map(describe).collect::<String>())?;
    Ok(())
}

/// How many steps it usually takes to learn a task, and about how much time.
fn takes(Solved { until, runs }: &Solved) -> String {
    let steps: Vec<u64> = runs.iter().map(|end| end.env_steps).collect();
    let mut steps = range_of_steps(&steps);
    if *until < USUAL_RATE {
        steps = format!("{steps} until {}", percent(f64::from(*until)));
    }
    let seconds = runs[runs.len() / 2].wall_s as f64;
    let time = match seconds {
        ..10.0 => "seconds".to_owned(),
        ..55.0 => format!("{:.0} s", 10.0 * (seconds / 10.0).round()),
        _ => format!("{:.0} min", (seconds / 60.0).round()),
    };
    format!("usually {steps}, {time} on one core")
}
