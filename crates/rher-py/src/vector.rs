//! Many environments, stepped together from Python.

use crate::any_env::Widths;
use crate::any_pool::{self, AnyPool, Size};
use crate::arrays::{as_doubles, read};
use crate::error::{InputError, InternalError, StateError, told, unlocked};
use crate::made::{Parts, chosen, kind_of, made_of};
use crate::picture::Painter;
use crate::threads::allowed;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods as _};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple, PyType};
use rher_envs::render::Image;
use rher_envs::{AutoReset, Chosen, Frames, PoolError, PoolRecord};
use serde::{Deserialize, Serialize};
use std::num::{NonZeroU16, NonZeroUsize};
use std::sync::{Mutex, MutexGuard, TryLockError};

/// Environments of one task that are stepped together, without Python's lock.
#[pyclass(frozen, module = "rher._rher")]
pub(crate) struct VectorEnv {
    made: Made,
    envs: usize,
    widths: Widths,
    slot: Mutex<Slot>,
    /// What steps write to, if it is not a new array each time.
    kept: Option<Arrays>,
}

/// What the environments are made of: a dictionary in Python.
#[derive(Clone, FromPyObject, IntoPyObject)]
struct Made {
    #[pyo3(item)]
    task: String,
    /// As JSON.
    #[pyo3(item)]
    options: String,
    #[pyo3(item)]
    envs: usize,
    /// As many as this process may use if it is None; never more than environments.
    #[pyo3(item)]
    threads: Option<usize>,
    #[pyo3(item)]
    auto_reset: String,
    #[pyo3(item)]
    reward_type: String,
    /// Whether every step makes new arrays.
    #[pyo3(item)]
    copy: bool,
    /// Those of the task if it is None.
    #[pyo3(item)]
    episode_steps: Option<NonZeroUsize>,
}

/// What changes in the environments.
struct Slot {
    /// None once they are closed.
    pool: Option<Box<dyn AnyPool>>,
    seeded: bool,
    /// The actions, kept to save an allocation.
    actions: Vec<f32>,
    /// Made when it is first needed.
    painter: Option<Painter>,
}

/// How environments got to where they are.
#[derive(Serialize, Deserialize)]
struct State {
    seeded: bool,
    record: PoolRecord,
}

/// What a step returns: one row for each environment.
struct Arrays {
    observations: Py<PyArray2<f64>>,
    achieved: Py<PyArray2<f64>>,
    desired: Py<PyArray2<f64>>,
    rewards: Py<PyArray1<f64>>,
    terminations: Py<PyArray1<bool>>,
    truncations: Py<PyArray1<bool>>,
}

impl Arrays {
    fn new(py: Python<'_>, envs: usize, widths: &Widths) -> Self {
        let zeros = |width| PyArray2::zeros(py, [envs, width], false).unbind();
        Self {
            observations: zeros(widths.observation),
            achieved: zeros(3 * widths.objects),
            desired: zeros(3 * widths.objects),
            rewards: PyArray1::zeros(py, envs, false).unbind(),
            terminations: PyArray1::zeros(py, envs, false).unbind(),
            truncations: PyArray1::zeros(py, envs, false).unbind(),
        }
    }

    /// Writes what the environments see now, and returns it as Gymnasium's dictionary.
    fn see<'py>(&self, py: Python<'py>, now: &Frames) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, array, numbers) in [
            (intern!(py, "observation"), &self.observations, &now.observations),
            (intern!(py, "achieved_goal"), &self.achieved, &now.achieved),
            (intern!(py, "desired_goal"), &self.desired, &now.desired),
        ] {
            let array = array.bind(py);
            as_doubles(numbers, array.try_readwrite().map_err(unwritable)?.as_slice_mut()?);
            dict.set_item(name, array)?;
        }
        Ok(dict)
    }
}

fn unwritable(error: numpy::BorrowError) -> PyErr {
    StateError::new_err(format!("an array that the environments write to is in use: {error}"))
}

#[pymethods]
impl VectorEnv {
    /// Makes the environments; `made` is a dictionary.
    #[new]
    fn new(py: Python<'_>, made: Made) -> PyResult<Self> {
        let Made { envs, episode_steps, copy, .. } = made;
        let auto_reset = match made.auto_reset.as_str() {
            "NextStep" => AutoReset::NextStep,
            "SameStep" => AutoReset::SameStep,
            "Disabled" => AutoReset::Never,
            auto_reset => {
                return Err(InputError::new_err(format!(
                    "autoreset_mode is `{auto_reset}`, expected NextStep, SameStep or Disabled"
                )));
            }
        };
        let rewards = kind_of(&made.reward_type)?;
        let invalid = |error: &dyn std::error::Error| InputError::new_err(told(error));
        let (widths, pool) = unlocked(py, || {
            let (task, options, one) = made_of(&made.task, &made.options, rewards)?;
            let threads = made.threads.unwrap_or_else(allowed).min(envs);
            let size = Size { envs, threads, auto_reset, rewards, episode_steps };
            let pool = any_pool::build(task, &options, size);
            let pool = pool.map_err(|error| invalid(&error))?.map_err(|error| invalid(&error))?;
            PyResult::Ok((one.widths(), pool))
        })??;
        let slot = Slot { pool: Some(pool), seeded: false, actions: Vec::new(), painter: None };
        let kept = (!copy).then(|| Arrays::new(py, envs, &widths));
        Ok(Self { made, envs, widths, slot: Mutex::new(slot), kept })
    }

    /// Whether the environments have been seeded.
    #[getter]
    fn is_seeded(&self) -> PyResult<bool> {
        Ok(self.lock()?.seeded)
    }

    /// Starts an episode in every environment: of its own seed, or the next one.
    #[pyo3(signature = (seeds=None, begun=None))]
    fn reset<'py>(
        &self,
        py: Python<'py>,
        seeds: Option<Vec<u64>>,
        begun: Option<Vec<Parts>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let mut slot = self.lock()?;
        let Slot { pool, seeded, .. } = &mut *slot;
        let pool = pool.as_mut().ok_or_else(closed)?;
        match &seeds {
            Some(seeds) => pool.seed(seeds).map_err(from_pool)?,
            None if *seeded => {}
            None => return Err(StateError::new_err("the first reset needs seeds")),
        }
        let all = vec![true; self.envs];
        self.begin(py, pool.as_mut(), &all, begun)?;
        *seeded = true;
        self.started(py, pool.as_ref(), &all)
    }

    /// Starts the next episode in the environments that `mask` marks.
    #[pyo3(signature = (mask, begun=None))]
    fn reset_where<'py>(
        &self,
        py: Python<'py>,
        mask: Vec<bool>,
        begun: Option<Vec<Parts>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let mut slot = self.lock()?;
        if !slot.seeded {
            return Err(StateError::new_err("the first reset is of all environments"));
        }
        let pool = slot.pool.as_mut().ok_or_else(closed)?;
        self.begin(py, pool.as_mut(), &mask, begun)?;
        self.started(py, pool.as_ref(), &mask)
    }

    /// Acts in every environment for one step: observations, rewards, terminations, truncations,
    /// infos.
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let mut slot = self.lock()?;
        let Slot { pool, actions: numbers, .. } = &mut *slot;
        let pool = pool.as_mut().ok_or_else(closed)?;
        read("the actions", actions, &[self.envs, self.widths.action], numbers)?;
        unlocked(py, || pool.step(numbers))?.map_err(from_pool)?;

        let new;
        let arrays = if let Some(kept) = &self.kept {
            kept
        } else {
            new = Arrays::new(py, self.envs, &self.widths);
            &new
        };
        let observations = arrays.see(py, pool.now())?;
        let rewards = arrays.rewards.bind(py);
        as_doubles(pool.rewards(), rewards.try_readwrite().map_err(unwritable)?.as_slice_mut()?);
        let truncations = arrays.truncations.bind(py);
        let mut ends = truncations.try_readwrite().map_err(unwritable)?;
        ends.as_slice_mut()?.copy_from_slice(pool.ended());
        drop(ends);
        let info = info(py, &pool.solved(), &vec![true; self.envs])?;
        (observations, rewards, arrays.terminations.bind(py), truncations, info).into_pyobject(py)
    }

    /// What was seen at the end of the episodes that ended in the last step, and whether their
    /// tasks were solved; with `SameStep`.
    fn last<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let slot = self.lock()?;
        let pool = slot.pool.as_ref().ok_or_else(closed)?;
        let frames = Arrays::new(py, self.envs, &self.widths).see(py, pool.last())?;
        let solved: Vec<bool> =
            pool.successes().iter().zip(pool.ended()).map(|(a, b)| *a && *b).collect();
        (frames, info(py, &solved, pool.ended())?).into_pyobject(py)
    }

    /// A picture of every environment, `[height, width, 3]`; their size is that of the first ones.
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: NonZeroU16,
        height: NonZeroU16,
    ) -> PyResult<Vec<Bound<'py, PyArray3<u8>>>> {
        let mut slot = self.lock()?;
        let Slot { pool, painter, .. } = &mut *slot;
        let pool = pool.as_mut().ok_or_else(closed)?;
        let painter = painter.get_or_insert_with(|| Painter::new([width, height]));
        let images: Result<Vec<_>, _> =
            unlocked(py, || (0..self.envs).map(|row| pool.picture(row, painter)).collect())?;
        let images = images.map_err(|error| StateError::new_err(told(&error)))?;
        let array = |image: Option<Image>| {
            let Some(Image { width, height, rgb }) = image else {
                let unseen = "there is nothing to see before the first reset";
                return Err(StateError::new_err(unseen));
            };
            PyArray1::from_vec(py, rgb).reshape([height, width, 3])
        };
        images.into_iter().map(array).collect()
    }

    /// How the environments got to where they are, as bytes.
    fn get_state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let slot = self.lock()?;
        let record = slot.pool.as_ref().ok_or_else(closed)?.record();
        let bytes = serde_json::to_vec(&State { seeded: slot.seeded, record });
        let bytes = bytes.map_err(|error| InternalError::new_err(told(&error)))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Plays the running episodes again, and returns what is seen then: observations and infos.
    fn set_state<'py>(&self, py: Python<'py>, state: &[u8]) -> PyResult<Bound<'py, PyTuple>> {
        let State { seeded, record } = serde_json::from_slice(state).map_err(|error| {
            InputError::new_err(format!("state: expected what get_state returned: {error}"))
        })?;
        let mut guard = self.lock()?;
        let slot = &mut *guard;
        let pool = slot.pool.as_mut().ok_or_else(closed)?;
        unlocked(py, || pool.play(&record))?.map_err(|error| {
            InputError::new_err(format!("state is of other environments: {}", told(&error)))
        })?;
        slot.seeded = seeded;
        self.started(py, pool.as_ref(), &vec![true; self.envs])
    }

    /// What unpickling and copying do.
    #[classmethod]
    fn _rebuilt(cls: &Bound<'_, PyType>, made: Made, state: Option<&[u8]>) -> PyResult<Self> {
        let py = cls.py();
        let new = Self::new(py, made)?;
        match state {
            Some(state) => drop(new.set_state(py, state)?),
            None => new.close()?,
        }
        Ok(new)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let env = slf.get();
        let is_open = env.lock()?.pool.is_some();
        let state = is_open.then(|| env.get_state(py)).transpose()?;
        (slf.get_type().getattr("_rebuilt")?, (env.made.clone(), state)).into_pyobject(py)
    }

    /// Frees the environments; they cannot be used any more.
    fn close(&self) -> PyResult<()> {
        self.lock()?.pool = None;
        Ok(())
    }
}

impl VectorEnv {
    /// Starts the next episode in the environments that `mask` marks, perhaps as it was chosen.
    fn begin(
        &self,
        py: Python<'_>,
        pool: &mut dyn AnyPool,
        mask: &[bool],
        begun: Option<Vec<Parts>>,
    ) -> PyResult<()> {
        let is_chosen = begun.is_some();
        let chosen: Vec<Chosen> = match begun {
            Some(begun) => begun.into_iter().map(chosen).collect(),
            None => vec![Chosen::default(); self.envs],
        };
        unlocked(py, || pool.reset_with(mask, &chosen))?.map_err(|error| match error {
            PoolError::Env { .. } if is_chosen => InputError::new_err(told(&error)),
            error => from_pool(error),
        })
    }

    /// Observations and infos of environments whose episodes have begun.
    fn started<'py>(
        &self,
        py: Python<'py>,
        pool: &dyn AnyPool,
        mask: &[bool],
    ) -> PyResult<Bound<'py, PyTuple>> {
        let new;
        let arrays = if let Some(kept) = &self.kept {
            kept
        } else {
            new = Arrays::new(py, self.envs, &self.widths);
            &new
        };
        let solved: Vec<bool> = pool.solved().iter().zip(mask).map(|(a, b)| *a && *b).collect();
        (arrays.see(py, pool.now())?, info(py, &solved, mask)?).into_pyobject(py)
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, Slot>> {
        match self.slot.try_lock() {
            Ok(slot) => Ok(slot),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(StateError::new_err("the environments are in use by another thread"))
            }
        }
    }
}

fn closed() -> PyErr {
    StateError::new_err("the environments are closed")
}

fn from_pool(error: PoolError) -> PyErr {
    match error {
        PoolError::NotReset { .. } | PoolError::Env { .. } => StateError::new_err(told(&error)),
        _ => InputError::new_err(told(&error)),
    }
}

/// `is_success`, and which rows have it.
fn info<'py>(py: Python<'py>, solved: &[bool], mask: &[bool]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let solved = solved.iter().map(|solved| f64::from(u8::from(*solved)));
    dict.set_item(intern!(py, "is_success"), PyArray1::from_iter(py, solved))?;
    dict.set_item(intern!(py, "_is_success"), PyArray1::from_slice(py, mask))?;
    Ok(dict)
}
