//! An environment that someone else wrote in Python, as the learner sees it.

use crate::any_env::read as positions;
use crate::arrays::read_as_is;
use crate::error::{InputError, told};
use crate::places::Places;
use numpy::PyArray1;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::goal::{Achieved, Desired, Scene, Tolerances};
use std::sync::{Arc, Mutex, PoisonError};

/// What Python says about its environment.
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
    /// In meters.
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
    /// What it returned last; kept to save allocations.
    seen: Seen,
    raised: Raised,
}

/// An environment did not do what was expected.
#[derive(Debug, thiserror::Error)]
enum ForeignError {
    #[error("it raised {0}")]
    Raised(String),
    #[error(
        "it ended its episode after {step} steps, expected {expected}: every episode must have \
         the same number of steps; wrap an environment that ends on success, so that its `step` \
         returns `terminated=False`"
    )]
    EndedEarly { step: usize, expected: usize },
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
        Ok(Self { env, spec, gripper, is_reach, desired, step: 0, seen: Seen::default(), raised })
    }

    /// What Python returned last: the observation, and the goals.
    fn scene(&self, observation: &mut [f32]) -> (Achieved<N>, Desired<N>) {
        observation.copy_from_slice(&self.seen.observation);
        let desired = positions(&self.seen.desired);
        let [gripper] = positions::<1>(&observation[self.gripper..]);
        // What is to be reached stays where it is.
        let objects = if self.is_reach { desired } else { positions(&self.seen.achieved) };
        (Achieved(Scene::new(gripper, objects)), Desired::of_task(desired))
    }
}

/// A dictionary of observations, copied.
#[derive(Default)]
struct Seen {
    observation: Vec<f32>,
    achieved: Vec<f32>,
    desired: Vec<f32>,
}

impl Seen {
    /// Reads the dictionary; `obs_dim` and `goal_dim` are the widths that it must have.
    fn read(&mut self, dict: &Bound<'_, PyAny>, obs_dim: usize, goal_dim: usize) -> PyResult<()> {
        let py = dict.py();
        for (key, out, width) in [
            (intern!(py, "observation"), &mut self.observation, obs_dim),
            (intern!(py, "achieved_goal"), &mut self.achieved, goal_dim),
            (intern!(py, "desired_goal"), &mut self.desired, goal_dim),
        ] {
            let what = key.to_str()?;
            read_as_is(what, &dict.get_item(key)?, &[width], out)?;
        }
        Ok(())
    }
}

impl<const N: usize> Env<N> for Foreign<N> {
    fn spec(&self) -> &EnvSpec<N> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        // Some environments take no larger seeds.
        let seed = seed & 0x7fff_ffff;
        let Self { env, seen, raised, .. } = self;
        call(raised, |py| {
            let arguments = PyDict::new(py);
            arguments.set_item(intern!(py, "seed"), seed)?;
            let result = env.bind(py).call_method(intern!(py, "reset"), (), Some(&arguments))?;
            seen.read(&result.get_item(0)?, observation.len(), 3 * N)
        })?;
        let (achieved, desired) = self.scene(observation);
        (self.desired, self.step) = (desired, 0);
        Ok(Start { achieved, desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let Self { env, seen, raised, .. } = self;
        let ended = call(raised, |py| {
            let action = PyArray1::from_slice(py, action);
            let result = env.bind(py).call_method1(intern!(py, "step"), (action,))?;
            seen.read(&result.get_item(0)?, observation.len(), 3 * N)?;
            Ok(result.get_item(2)?.is_truthy()? || result.get_item(3)?.is_truthy()?)
        })?;
        self.step += 1;
        let (step, expected) = (self.step, self.spec.episode_steps);
        if ended && step < expected {
            return Err(EnvError::new(ForeignError::EndedEarly { step, expected }));
        }
        Ok(self.scene(observation).0)
    }
}

/// Calls Python, and keeps what it raises.
fn call<T>(raised: &Raised, work: impl FnOnce(Python<'_>) -> PyResult<T>) -> Result<T, EnvError> {
    Python::attach(|py| {
        work(py).map_err(|error| {
            let text = error.to_string();
            *raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            EnvError::new(ForeignError::Raised(text))
        })
    })
}
