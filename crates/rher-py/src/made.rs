//! From the task and options that Python names to an environment.

use crate::any_env::{self, AnyEnv};
use crate::error::{InputError, told};
use pyo3::prelude::*;
use rher_envs::{Chosen, Options, RewardKind, Task};

/// Names of the tasks, the simplest first.
#[pyfunction]
pub(crate) fn tasks() -> Vec<&'static str> {
    Task::ALL.iter().map(|task| task.name()).collect()
}

/// What the sub-tasks of a task are called, in their order.
#[pyfunction]
pub(crate) fn subtasks(task: &str) -> PyResult<Vec<String>> {
    let task: Task = task.parse().map_err(|error| InputError::new_err(told(&error)))?;
    Ok(task.subtasks())
}

/// An environment of the task and options that Python names.
pub(crate) fn made_of(
    task: &str,
    options: &str,
    kind: RewardKind,
) -> PyResult<(Task, Options, Box<dyn AnyEnv>)> {
    let (task, options) = parse(task, options)?;
    let env = any_env::build(task, &options, kind);
    Ok((task, options, env.map_err(|error| InputError::new_err(told(&error)))?))
}

/// The kind of rewards that Python names.
pub(crate) fn kind_of(reward_type: &str) -> PyResult<RewardKind> {
    match reward_type {
        "sparse" => Ok(RewardKind::Sparse),
        "dense" => Ok(RewardKind::Dense),
        other => Err(InputError::new_err(format!(
            "reward_type is '{other}', expected 'sparse' or 'dense'"
        ))),
    }
}

/// What is chosen of the beginning of an episode, as Python has it: places of objects `[3 N]`, turns
/// `[N]`, targets `[3 N]`.
pub(crate) type Parts = (Option<Vec<f32>>, Option<Vec<f32>>, Option<Vec<f32>>);

/// What is chosen, from Python.
pub(crate) fn chosen((objects, turns, targets): Parts) -> Chosen {
    Chosen { objects, turns, targets }
}

/// What is chosen, to Python.
pub(crate) fn parts(Chosen { objects, turns, targets }: Chosen) -> Parts {
    (objects, turns, targets)
}

/// The task and its options that Python names; `options` are JSON, all of them optional.
pub(crate) fn parse(task: &str, options: &str) -> PyResult<(Task, Options)> {
    let task: Task = task.parse().map_err(|error| InputError::new_err(told(&error)))?;
    let options: Options = options
        .parse()
        .map_err(|error| InputError::new_err(format!("options of `{task}`: {error}")))?;
    let options =
        options.check(task.options()).map_err(|error| InputError::new_err(told(&error)))?;
    Ok((task, options))
}
