//! One environment, stepped from Python.

use crate::any_env::{AnyEnv, Frame, Widths};
use crate::arrays::{Rows, doubles, read};
use crate::error::{InputError, StateError, told, unlocked};
use crate::made::{Parts, chosen, kind_of, made_of};
use crate::picture::Painter;
use crate::state::{Record, State};
use numpy::{PyArray1, PyArray3, PyArrayDyn, PyArrayMethods as _};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use rher_core::seed::{Purpose, Seed};
use rher_envs::{Options, Task};
use std::num::NonZeroU16;
use std::sync::{Mutex, MutexGuard, TryLockError};

/// An environment of one task.
///
/// All numbers go in and out as NumPy arrays; every array is a new one.
#[pyclass(frozen, module = "rher._rher")]
pub(crate) struct Env {
    task: Task,
    options: Options,
    reward_type: String,
    widths: Widths,
    slot: Mutex<Slot>,
}

/// What changes in an environment.
struct Slot {
    /// None once it is closed.
    env: Option<Box<dyn AnyEnv>>,
    /// Seed of its first episode, from which those of the later ones follow; None before.
    seed: Option<u64>,
    /// Episodes started since.
    episodes: u64,
    /// The episode that is running.
    record: Option<Record>,
    /// The action, kept to save an allocation.
    action: Vec<f32>,
    /// Made when it is first needed.
    painter: Option<Painter>,
}

impl Slot {
    fn open(&mut self) -> PyResult<&mut Box<dyn AnyEnv>> {
        self.env.as_mut().ok_or_else(|| StateError::new_err("the environment is closed"))
    }
}

#[pymethods]
impl Env {
    /// An environment of `task`, with `options` as JSON.
    #[new]
    #[pyo3(signature = (task, options, reward_type="sparse"))]
    fn new(py: Python<'_>, task: &str, options: &str, reward_type: &str) -> PyResult<Self> {
        let kind = kind_of(reward_type)?;
        let (task, options, env) = unlocked(py, || made_of(task, options, kind))??;
        let widths = env.widths();
        let slot = Slot {
            env: Some(env),
            seed: None,
            episodes: 0,
            record: None,
            action: Vec::with_capacity(widths.action),
            painter: None,
        };
        let reward_type = reward_type.to_owned();
        Ok(Self { task, options, reward_type, widths, slot: Mutex::new(slot) })
    }

    /// Name of the task.
    #[getter]
    fn task(&self) -> &'static str {
        self.task.name()
    }

    /// The options, every one of them, as JSON.
    #[getter]
    fn options(&self) -> String {
        self.options.to_string()
    }

    /// Length of an observation.
    #[getter]
    fn observation_width(&self) -> usize {
        self.widths.observation
    }

    /// Length of an action.
    #[getter]
    fn action_width(&self) -> usize {
        self.widths.action
    }

    /// Number of objects.
    #[getter]
    fn objects(&self) -> usize {
        self.widths.objects
    }

    /// Steps of an episode.
    #[getter]
    fn episode_steps(&self) -> usize {
        self.widths.episode_steps
    }

    /// Distance below which a goal counts as reached, in meters.
    #[getter]
    fn tolerance(&self) -> f32 {
        self.widths.tolerance
    }

    /// Whether the environment has been seeded.
    #[getter]
    fn is_seeded(&self) -> PyResult<bool> {
        Ok(self.lock()?.seed.is_some())
    }

    /// Starts the next episode; with a seed, the first one of that seed.
    #[pyo3(signature = (seed=None, begun=None))]
    fn reset<'py>(
        &self,
        py: Python<'py>,
        seed: Option<u64>,
        begun: Option<Parts>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let mut guard = self.lock()?;
        let slot = &mut *guard;
        slot.open()?;
        if let Some(seed) = seed {
            (slot.seed, slot.episodes) = (Some(seed), 0);
        }
        let Some(first) = slot.seed else {
            return Err(StateError::new_err("the first reset needs a seed"));
        };
        let seed = match slot.episodes {
            0 => first,
            count => Seed(first).episode(Purpose::Environment, count),
        };
        slot.record = None;
        let env = slot.open()?;
        let is_chosen = begun.is_some();
        let chosen = begun.map(chosen).unwrap_or_default();
        unlocked(py, || env.reset(seed, &chosen))?.map_err(|error| {
            let text = told(&error);
            if is_chosen { InputError::new_err(text) } else { StateError::new_err(text) }
        })?;
        slot.episodes += 1;
        let record = Record { seed, chosen, actions: Vec::with_capacity(64 * self.widths.action) };
        slot.record = Some(record);
        let frame = slot.open()?.frame();
        (observation(py, frame)?, info(py, frame)?).into_pyobject(py)
    }

    /// Acts for one step: observation, reward, terminated, truncated, info.
    fn step<'py>(
        &self,
        py: Python<'py>,
        action: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let mut guard = self.lock()?;
        let Slot { env, record, action: numbers, .. } = &mut *guard;
        let Some(env) = env else { return Err(StateError::new_err("the environment is closed")) };
        let Some(Record { actions, .. }) = record else {
            return Err(StateError::new_err("reset the environment before its first step"));
        };
        read("the action", action, &[self.widths.action], numbers)?;
        unlocked(py, || env.step(numbers))?.map_err(|error| StateError::new_err(told(&error)))?;
        actions.extend_from_slice(numbers);
        let frame = env.frame();
        (observation(py, frame)?, f64::from(frame.reward), false, false, info(py, frame)?)
            .into_pyobject(py)
    }

    /// Rewards of goals, each `[..., 3 N]`: `[...]`.
    fn compute_reward<'py>(
        &self,
        achieved: &Bound<'py, PyAny>,
        desired: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let py = achieved.py();
        let guard = self.lock()?;
        let env = guard.env.as_ref();
        let env = env.ok_or_else(|| StateError::new_err("the environment is closed"))?;
        let width = 3 * self.widths.objects;
        let [achieved, desired] = [("achieved_goal", achieved), ("desired_goal", desired)]
            .map(|(what, goals)| Rows::read(what, goals, width, "")?.finite(what));
        let (achieved, desired) = (achieved?, desired?);
        if achieved.batch != desired.batch {
            let shape = |rows: &Rows| [rows.batch.as_slice(), &[width]].concat();
            let (a, d) = (shape(&achieved), shape(&desired));
            return Err(InputError::new_err(format!(
                "achieved_goal has shape {a:?} and desired_goal {d:?}: expected the same shape"
            )));
        }
        let rewards = env.rewards(&achieved.numbers, &desired.numbers);
        PyArray1::from_vec(py, rewards).reshape(achieved.batch)
    }

    /// The moment of the episode that it is at.
    fn get_state(&self) -> PyResult<State> {
        let mut guard = self.lock()?;
        guard.open()?;
        let Slot { env: Some(env), record: Some(record), .. } = &*guard else {
            return Err(StateError::new_err("there is no state before the first reset"));
        };
        let options = self.options.to_string();
        Ok(State::new(self.task.name(), options, record.clone(), env.as_ref()))
    }

    /// Returns to a moment that `get_state` took, and shows it: observation and info.
    fn set_state<'py>(&self, py: Python<'py>, state: &State) -> PyResult<Bound<'py, PyTuple>> {
        let mut guard = self.lock()?;
        let env = guard.open()?;
        if state.task != self.task.name() || !state.restore(env.as_mut()) {
            let (task, options) = (&state.task, &state.options);
            return Err(InputError::new_err(format!(
                "the state is of `{task}` with {options}, expected one of `{}` with {}",
                self.task, self.options
            )));
        }
        guard.record = Some(state.record.clone());
        let frame = guard.open()?.frame();
        (observation(py, frame)?, info(py, frame)?).into_pyobject(py)
    }

    /// A picture of this moment, `[height, width, 3]`; its size is that of the first one.
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: NonZeroU16,
        height: NonZeroU16,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let mut guard = self.lock()?;
        let Slot { env, record, painter, .. } = &mut *guard;
        let Some(env) = env else { return Err(StateError::new_err("the environment is closed")) };
        if record.is_none() {
            return Err(StateError::new_err("there is nothing to see before the first reset"));
        }
        let painter = painter.get_or_insert_with(|| Painter::new([width, height]));
        let image = unlocked(py, || env.picture(painter))?;
        let image = image.map_err(|error| StateError::new_err(told(&error)))?;
        PyArray1::from_vec(py, image.rgb).reshape([image.height, image.width, 3])
    }

    /// Frees the environment; it cannot be used any more.
    fn close(&self) -> PyResult<()> {
        self.lock()?.env = None;
        Ok(())
    }

    /// What unpickling and copying do.
    #[classmethod]
    fn _rebuilt(
        cls: &Bound<'_, PyType>,
        task: &str,
        options: &str,
        reward_type: &str,
        stream: (Option<u64>, u64),
        closed: bool,
        state: Option<&Bound<'_, State>>,
    ) -> PyResult<Self> {
        let py = cls.py();
        let env = Self::new(py, task, options, reward_type)?;
        (env.lock()?.seed, env.lock()?.episodes) = stream;
        if let Some(state) = state {
            env.set_state(py, state.get())?;
        }
        if closed {
            env.close()?;
        }
        Ok(env)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let env = slf.get();
        let (stream, closed, running) = {
            let slot = env.lock()?;
            ((slot.seed, slot.episodes), slot.env.is_none(), slot.record.is_some())
        };
        let state = (running && !closed).then(|| env.get_state()).transpose()?;
        let arguments = (env.task(), env.options(), &env.reward_type, stream, closed, state);
        (slf.get_type().getattr("_rebuilt")?, arguments).into_pyobject(slf.py())
    }
}

impl Env {
    fn lock(&self) -> PyResult<MutexGuard<'_, Slot>> {
        match self.slot.try_lock() {
            Ok(slot) => Ok(slot),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(StateError::new_err(
                "the environment is in use by another thread: make one for each thread",
            )),
        }
    }
}

/// The dictionary that Gymnasium-Robotics' environments return.
fn observation<'py>(py: Python<'py>, frame: &Frame) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item(intern!(py, "observation"), doubles(py, &frame.observation))?;
    dict.set_item(intern!(py, "achieved_goal"), doubles(py, &frame.achieved))?;
    dict.set_item(intern!(py, "desired_goal"), doubles(py, &frame.desired))?;
    Ok(dict)
}

fn info<'py>(py: Python<'py>, frame: &Frame) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item(intern!(py, "is_success"), f64::from(u8::from(frame.success)))?;
    Ok(dict)
}
