//! A moment of an episode that an environment can return to.

use crate::any_env::{AnyEnv, Snapshot};
use crate::error::{InputError, told, unlocked};
use crate::made::{Parts, chosen, made_of, parts};
use pyo3::prelude::*;
use pyo3::types::{PyTuple, PyType};
use rher_envs::{Chosen, RewardKind};
use std::sync::{Mutex, PoisonError};

/// How an episode got to where it is: it can be played again from this, to the last bit.
#[derive(Clone, Default)]
pub(crate) struct Record {
    /// Seed of the episode.
    pub(crate) seed: u64,
    /// What was chosen of how it began.
    pub(crate) chosen: Chosen,
    /// `[steps, action]`.
    pub(crate) actions: Vec<f32>,
}

impl Record {
    /// Plays the episode again.
    pub(crate) fn play(&self, env: &mut dyn AnyEnv) -> PyResult<()> {
        let failed = |error| InputError::new_err(told(&error));
        env.reset(self.seed, &self.chosen).map_err(failed)?;
        let width = env.widths().action;
        self.actions.chunks_exact(width).try_for_each(|action| env.step(action)).map_err(failed)
    }
}

/// A moment of an episode: `Env.get_state` takes one, `Env.set_state` returns to it.
///
/// It does not change, and can be pickled.
#[pyclass(frozen, module = "rher._rher")]
pub(crate) struct State {
    pub(crate) task: String,
    /// As JSON.
    pub(crate) options: String,
    pub(crate) record: Record,
    snapshot: Mutex<Snapshot>,
}

impl State {
    pub(crate) fn new(task: &str, options: String, record: Record, env: &dyn AnyEnv) -> Self {
        let snapshot = Mutex::new(env.snapshot());
        Self { task: task.to_owned(), options, record, snapshot }
    }

    /// Brings an environment of the same task and options here.
    pub(crate) fn restore(&self, env: &mut dyn AnyEnv) -> bool {
        env.restore(&self.snapshot.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[pymethods]
impl State {
    /// Plays the episode again: what unpickling does.
    #[classmethod]
    fn _replayed(
        cls: &Bound<'_, PyType>,
        task: &str,
        options: String,
        seed: u64,
        actions: Vec<f32>,
        begun: Parts,
    ) -> PyResult<Self> {
        let (_, _, mut env) = made_of(task, &options, RewardKind::Sparse)?;
        let record = Record { seed, chosen: chosen(begun), actions };
        unlocked(cls.py(), || record.play(env.as_mut()))??;
        Ok(Self::new(task, options, record, env.as_ref()))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let Self { task, options, record, .. } = slf.get();
        let rebuild = slf.get_type().getattr("_replayed")?;
        let begun = parts(record.chosen.clone());
        let arguments = (task, options, record.seed, record.actions.clone(), begun);
        (rebuild, arguments).into_pyobject(slf.py())
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let Self { task, record: Record { seed, actions, .. }, .. } = self;
        format!("State(task='{task}', seed={seed}, numbers_of_actions={})", actions.len())
    }
}
