//! `rher tasks`: what can be learned.

use crate::cli::TasksArgs;
use crate::printer::Printer;
use crate::tables::{table, text};
use rher_core::goal::EncodedGoal;
use rher_envs::{EnvVisitor, Simulated, Task};
use serde::Serialize;

/// What holds for every episode of a task.
#[derive(Serialize)]
struct TaskFacts {
    name: String,
    objects: usize,
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

struct Describe;

impl EnvVisitor for Describe {
    type Output = TaskFacts;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> TaskFacts {
        let env = build();
        let spec = env.spec();
        let names = spec.names.clone();
        TaskFacts {
            name: spec.name.clone(),
            objects: N,
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
    let facts: Vec<TaskFacts> = Task::all().into_iter().map(|task| task.visit(Describe)).collect();
    if args.json {
        printer.data(&serde_json::to_string_pretty(&facts)?)?;
        return Ok(());
    }
    let mut listing = table();
    listing.set_header([
        "task",
        "objects",
        "sub-tasks",
        "observation",
        "action",
        "goal",
        "encoded goal",
        "steps",
        "tolerance (m)",
    ]);
    for task in facts {
        let tolerance: Vec<String> = task.tolerance.iter().map(f32::to_string).collect();
        listing.add_row([
            task.name,
            task.objects.to_string(),
            task.subtasks.to_string(),
            task.observation.to_string(),
            task.action.to_string(),
            task.goal.to_string(),
            task.encoded_goal.to_string(),
            task.episode_steps.to_string(),
            tolerance.join(" "),
        ]);
    }
    printer.data(&text(&listing))?;
    Ok(())
}
