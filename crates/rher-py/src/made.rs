//! From the task and options that Python names to an environment.

use crate::any_env::{self, AnyEnv};
use crate::error::{InputError, told};
use pyo3::prelude::*;
use rher_envs::{Options, Task};

/// Names of the tasks, the simplest first.
#[pyfunction]
pub(crate) fn tasks() -> Vec<&'static str> {
    Task::ALL.iter().map(|task| task.name()).collect()
}

/// An environment of the task and options that Python names.
pub(crate) fn made_of(task: &str, options: &str) -> PyResult<(Task, Options, Box<dyn AnyEnv>)> {
    let (task, options) = parse(task, options)?;
    let env = any_env::build(task, &options).map_err(|error| InputError::new_err(told(&error)))?;
    Ok((task, options, env))
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
