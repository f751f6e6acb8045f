//! A trained policy, called from Python.

use crate::any_env::read as positions;
use crate::arrays::Rows;
use crate::error::{FileError, InputError, PolicyError, told, unlocked};
use crate::places::Places;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple, PyType};
use rher_core::env::EnvSpec;
use rher_core::goal::{Achieved, Desired, Leg, Scene};
use rher_core::policy::{Policy as CorePolicy, PolicyError as CorePolicyError, PolicyInfo};
use rher_envs::{Options, Task};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A trained policy: `policy(observation, goal)` is an action.
#[pyclass(frozen, module = "rher._rher")]
pub(crate) struct Policy {
    policy: Arc<CorePolicy>,
    places: Places,
}

/// A policy file that cannot be used, on its way to Python.
pub(crate) struct PolicyFailure(CorePolicyError);

impl From<PolicyFailure> for PyErr {
    fn from(PolicyFailure(error): PolicyFailure) -> Self {
        match error {
            CorePolicyError::File(_) => FileError::new_err(told(&error)),
            _ => PolicyError::new_err(told(&error)),
        }
    }
}

impl Policy {
    /// A policy and the layout of its observations, which it may remember itself.
    pub(crate) fn new(policy: CorePolicy) -> PyResult<Self> {
        let PolicyInfo { task, variant, objects, .. } = policy.info();
        if !(1..=3).contains(objects) {
            return Err(too_many(*objects));
        }
        let of_task = || {
            let task: Task = task.parse().ok()?;
            let options = variant.parse().unwrap_or_else(|_| Options::of(task.options()));
            Places::of_task(task, &options).ok()?
        };
        let of_variant = || serde_json::from_str(variant).ok();
        let places = of_variant().or_else(of_task).ok_or_else(|| {
            PolicyError::new_err(format!(
                "the policy was trained for `{task}`, and does not say where in an observation \
                 the gripper is"
            ))
        })?;
        Ok(Self { policy: Arc::new(policy), places })
    }
}

#[pymethods]
impl Policy {
    /// Reads a policy file.
    #[classmethod]
    fn load(cls: &Bound<'_, PyType>, path: PathBuf) -> PyResult<Self> {
        let policy = unlocked(cls.py(), || CorePolicy::load(&path))?;
        Self::new(policy.map_err(PolicyFailure)?)
    }

    /// Writes a policy file; the file is complete or absent.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Ok(unlocked(py, || self.policy.save(&path))?.map_err(PolicyFailure)?)
    }

    /// Name of the environment that it was trained in.
    #[getter]
    fn task(&self) -> &str {
        &self.policy.info().task
    }

    /// Number of objects in its goals.
    #[getter]
    fn objects(&self) -> usize {
        self.policy.info().objects
    }

    /// Length of an observation.
    #[getter]
    fn observation_width(&self) -> usize {
        self.policy.info().obs_dim
    }

    /// Length of an action.
    #[getter]
    fn action_width(&self) -> usize {
        self.policy.info().action_dim
    }

    /// The action for an observation and a goal, or the actions for a batch of them.
    #[pyo3(signature = (observation, goal=None))]
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        observation: &Bound<'py, PyAny>,
        goal: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let PolicyInfo { objects, obs_dim: width, action_dim: action, .. } = *self.policy.info();
        let dict = observation.cast::<PyDict>().ok();
        let item = |name| match &dict {
            Some(dict) => dict.get_item(name),
            None => Ok(None),
        };
        let (goal_of_dict, achieved) = (item("desired_goal")?, item("achieved_goal")?);
        let read = |what, array: &Bound<'py, PyAny>, width| {
            Rows::read(what, array, width, ": is the policy for another task?")
        };
        let numbers = item("observation")?;
        let Rows { batch, numbers: observations } =
            read("observation", numbers.as_ref().unwrap_or(observation), width)?;
        let Some(goal) = goal.or(goal_of_dict.as_ref()) else {
            return Err(InputError::new_err(
                "a goal is missing: expected policy(observation, goal)",
            ));
        };
        let goals_of = |what, goals: &Bound<'py, PyAny>| {
            let goals = read(what, goals, 3 * objects)?;
            if goals.batch != batch {
                return Err(InputError::new_err(format!(
                    "observation has rows of shape {batch:?} and {what} of {:?}: expected the same",
                    goals.batch
                )));
            }
            Ok(goals.numbers)
        };
        let goals = goals_of("goal", goal)?;
        let achieved = achieved.map(|goals| goals_of("achieved_goal", &goals)).transpose()?;
        let given = Given { observations, goals, achieved };
        let actions = unlocked(py, || match objects {
            1 => self.act::<1>(&given),
            2 => self.act::<2>(&given),
            3 => self.act::<3>(&given),
            _ => Err(too_many(objects)),
        })??;
        let shape = [batch, vec![action]].concat();
        PyArray1::from_vec(py, actions).reshape(shape)
    }

    /// What unpickling and copying do.
    #[classmethod]
    fn _from_bytes(cls: &Bound<'_, PyType>, file: &[u8]) -> PyResult<Self> {
        let path = Path::new("a pickled policy");
        let policy = unlocked(cls.py(), || CorePolicy::from_bytes(file, path))?;
        Self::new(policy.map_err(PolicyFailure)?)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let file = PyBytes::new(py, &slf.get().policy.to_bytes());
        (slf.get_type().getattr("_from_bytes")?, (file,)).into_pyobject(py)
    }

    fn __repr__(&self) -> String {
        let PolicyInfo { task, objects, obs_dim: observation, action_dim: action, .. } =
            self.policy.info();
        format!(
            "Policy(task='{task}', objects={objects}, observation={observation}, action={action})"
        )
    }
}

/// What a batch of actions is chosen by.
struct Given {
    observations: Vec<f32>,
    goals: Vec<f32>,
    /// None to find it in the observations.
    achieved: Option<Vec<f32>>,
}

impl Policy {
    /// The actions of the last sub-task, row by row.
    fn act<const N: usize>(&self, given: &Given) -> PyResult<Vec<f32>> {
        let PolicyInfo { obs_dim, action_dim, subtasks, .. } = *self.policy.info();
        let spec = EnvSpec::<N> { subtasks, ..EnvSpec::new("", obs_dim, action_dim, 1) };
        let unfit = |error| PolicyError::new_err(told(&error));
        let mut actor = self.policy.actor(&spec).map_err(unfit)?;
        let stage = actor.task();
        let mut actions = vec![0.0; given.observations.len() / obs_dim * action_dim];
        for (row, action) in actions.chunks_exact_mut(action_dim).enumerate() {
            let observation = &given.observations[row * obs_dim..(row + 1) * obs_dim];
            let goal = row * 3 * N..(row + 1) * 3 * N;
            let desired = positions::<N>(&given.goals[goal.clone()]);
            let at = |place: usize| positions::<1>(&observation[place..place + 3])[0];
            let objects = match (stage.leg(), &given.achieved, &self.places.objects) {
                // What is to be reached stays where it is.
                (Leg::Reach, _, _) => desired,
                (Leg::Place, Some(achieved), _) => positions::<N>(&achieved[goal]),
                (Leg::Place, None, Some(places)) => std::array::from_fn(|i| at(places[i])),
                (Leg::Place, None, None) => {
                    return Err(InputError::new_err(
                        "where the objects are is not in the observation: expected the dictionary \
                         that the environment returns",
                    ));
                }
            };
            let scene = Achieved(Scene { gripper: at(self.places.gripper), objects });
            actor
                .act(stage, observation, &scene, &Desired::of_task(desired), action)
                .map_err(|error| InputError::new_err(format!("row {row}: {}", told(&error))))?;
        }
        Ok(actions)
    }
}

fn too_many(objects: usize) -> PyErr {
    PolicyError::new_err(format!("the policy is for {objects} objects, expected 1 to 3"))
}
