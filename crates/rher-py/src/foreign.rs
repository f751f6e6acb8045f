//! An environment that someone else wrote in Python, as the learner sees it.

use crate::any_env::read as positions;
use crate::error::{InputError, told};
use crate::places::Places;
use numpy::{AllowTypeChange, PyArray1, PyArrayLike1};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::goal::{Achieved, Desired, Scene, Tolerances};
use std::sync::{Arc, Mutex, PoisonError};

/// What Python tells of its environment.
#[derive(Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct About {
    /// Name of the environment.
    pub(crate) name: String,
    /// Objects in it; 0 if its goal is a place for the gripper.
    pub(crate) objects: usize,
    pub(crate) observation: usize,
    pub(crate) action: usize,
    pub(crate) episode_steps: usize,
    /// Metres.
    pub(crate) tolerance: f32,
    pub(crate) places: Places,
}

/// The exception that an environment raised, which errors of the core cannot carry.
pub(crate) type Raised = Arc<Mutex<Option<PyErr>>>;

/// A Gymnasium environment with dictionaries of `observation`, `achieved_goal`, `desired_goal`.
pub(crate) struct Foreign<const N: usize> {
    env: Py<PyAny>,
    spec: EnvSpec<N>,
    /// Where in an observation the gripper's position is.
    gripper: usize,
    /// Whether its goal is a place for the gripper.
    is_reach: bool,
    desired: Desired<N>,
    /// Steps of this episode.
    step: usize,
    raised: Raised,
}

/// An environment did not do what was expected.
#[derive(Debug, thiserror::Error)]
enum ForeignError {
    #[error("it raised {0}")]
    Raised(String),
    #[error(
        "it ended its episode after {step} steps, expected {expected}: every episode must have \
             as many steps"
    )]
    EndedEarly { step: usize, expected: usize },
    #[error("`{key}` of its observation has {got} numbers, expected {expected}")]
    Width { key: &'static str, got: usize, expected: usize },
}

impl<const N: usize> Foreign<N> {
    pub(crate) fn new(env: Py<PyAny>, about: &About, raised: Raised) -> PyResult<Self> {
        let About { name, objects, observation, action, episode_steps, tolerance, places } = about;
        let variant = serde_json::to_string(places);
        let is_reach = *objects == 0;
        let spec = EnvSpec {
            variant: variant.map_err(|error| InputError::new_err(told(&error)))?,
            subtasks: if is_reach { 1 } else { 2 * N },
            tolerances: Tolerances::uniform(*tolerance),
            ..EnvSpec::new(name, *observation, *action, *episode_steps)
        };
        let desired = Desired::of_task(positions(&vec![0.0; 3 * N]));
        let gripper = places.gripper;
        Ok(Self { env, spec, gripper, is_reach, desired, step: 0, raised })
    }

    /// Calls Python, and keeps what it raises.
    fn call<T>(&self, work: impl FnOnce(Python<'_>) -> PyResult<T>) -> Result<T, EnvError> {
        Python::attach(|py| {
            work(py).map_err(|error| {
                let text = error.to_string();
                let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
                *raised = Some(error);
                EnvError::new(ForeignError::Raised(text))
            })
        })
    }

    /// What the dictionary `seen` says: the observation, and the goals.
    fn scene(
        &self,
        seen: &Seen,
        observation: &mut [f32],
    ) -> Result<(Achieved<N>, Desired<N>), EnvError> {
        for (key, numbers, expected) in [
            ("observation", &seen.observation, observation.len()),
            ("achieved_goal", &seen.achieved, 3 * N),
            ("desired_goal", &seen.desired, 3 * N),
        ] {
            let got = numbers.len();
            if got != expected {
                return Err(EnvError::new(ForeignError::Width { key, got, expected }));
            }
        }
        observation.copy_from_slice(&seen.observation);
        let desired = positions(&seen.desired);
        let [gripper] = positions::<1>(&observation[self.gripper..]);
        // What is to be reached stays where it is.
        let objects = if self.is_reach { desired } else { positions(&seen.achieved) };
        Ok((Achieved(Scene { gripper, objects }), Desired::of_task(desired)))
    }
}

/// A dictionary of observations, copied.
struct Seen {
    observation: Vec<f32>,
    achieved: Vec<f32>,
    desired: Vec<f32>,
}

impl Seen {
    fn of(dict: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = dict.py();
        let numbers = |key: &Bound<'_, _>| -> PyResult<Vec<f32>> {
            let array: PyArrayLike1<'_, f32, AllowTypeChange> = dict.get_item(key)?.extract()?;
            Ok(array.as_array().iter().copied().collect())
        };
        Ok(Self {
            observation: numbers(intern!(py, "observation"))?,
            achieved: numbers(intern!(py, "achieved_goal"))?,
            desired: numbers(intern!(py, "desired_goal"))?,
        })
    }
}

impl<const N: usize> Env<N> for Foreign<N> {
    fn spec(&self) -> &EnvSpec<N> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        // Some environments take no larger seeds.
        let seed = seed & 0x7fff_ffff;
        let seen = self.call(|py| {
            let arguments = PyDict::new(py);
            arguments.set_item(intern!(py, "seed"), seed)?;
            let env = self.env.bind(py);
            let result = env.call_method(intern!(py, "reset"), (), Some(&arguments))?;
            Seen::of(&result.get_item(0)?)
        })?;
        let (achieved, desired) = self.scene(&seen, observation)?;
        (self.desired, self.step) = (desired, 0);
        Ok(Start { achieved, desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let (seen, ended) = self.call(|py| {
            let env = self.env.bind(py);
            let action = PyArray1::from_slice(py, action);
            let result = env.call_method1(intern!(py, "step"), (action,))?;
            let ended = result.get_item(2)?.is_truthy()? || result.get_item(3)?.is_truthy()?;
            Ok((Seen::of(&result.get_item(0)?)?, ended))
        })?;
        self.step += 1;
        let (step, expected) = (self.step, self.spec.episode_steps);
        if ended && step < expected {
            return Err(EnvError::new(ForeignError::EndedEarly { step, expected }));
        }
        let (achieved, _) = self.scene(&seen, observation)?;
        Ok(achieved)
    }
}
