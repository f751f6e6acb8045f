//! A trained policy, called from Python.

use crate::arrays::Rows;
use crate::error::{FileError, InputError, InternalError, PolicyError, told, unlocked};
use crate::goals::{GoalLayout, position};
use crate::places::Places;
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyMapping, PyTuple, PyType};
use rher_core::env::EnvSpec;
use rher_core::goal::{Achieved, Desired, Leg, Scene, Tails};
use rher_core::policy::{Policy as CorePolicy, PolicyError as CorePolicyError, PolicyInfo};
use rher_envs::{Options, Task};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A trained policy: `policy(observation, goal)` is an action.
#[pyclass(frozen, module = "rher._rher")]
pub(crate) struct Policy {
    frozen: Arc<CorePolicy>,
    places: Places,
    /// Where the episodes began that it acts in, if it was told.
    begun: Option<Given>,
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
    /// The policy itself.
    pub(crate) fn frozen(&self) -> &CorePolicy {
        &self.frozen
    }

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
        let width = policy.info().obs_dim;
        let begin = std::iter::once(&places.gripper).chain(places.objects.iter().flatten());
        let is_inside =
            |begin: &usize| begin.checked_add(places.axes).is_some_and(|end| end <= width);
        if !((2..=3).contains(&places.axes) && begin.into_iter().all(is_inside)) {
            return Err(PolicyError::new_err(format!(
                "the policy has positions outside of its {width} numbers: the file is damaged"
            )));
        }
        Ok(Self { frozen: Arc::new(policy), places, begun: None })
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

    /// The policy that ships with the package for a task.
    #[classmethod]
    fn pretrained(cls: &Bound<'_, PyType>, task: &str) -> PyResult<Self> {
        let found = task.parse::<Task>().map_err(|error| InputError::new_err(told(&error)));
        let shipped = rher_policies::of(found?.name());
        let shipped = shipped.ok_or_else(|| {
            InputError::new_err(format!("no policy of `{task}` ships with this package"))
        })?;
        Self::new(unlocked(cls.py(), || shipped.policy())?)
    }

    /// Writes a policy file; the file is complete or absent.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Ok(unlocked(py, || self.frozen.save(&path))?.map_err(PolicyFailure)?)
    }

    /// Name of the environment that it was trained in.
    #[getter]
    fn task(&self) -> &str {
        &self.frozen.info().task
    }

    /// Number of objects in its goals.
    #[getter]
    fn objects(&self) -> usize {
        self.frozen.info().objects
    }

    /// Length of an observation.
    #[getter]
    fn observation_width(&self) -> usize {
        self.frozen.info().obs_dim
    }

    /// Length of an action.
    #[getter]
    fn action_width(&self) -> usize {
        self.frozen.info().action_dim
    }

    /// What its numbers are called.
    #[getter]
    fn names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        as_dict(py, self.frozen.names())
    }

    /// The rate, the frame and the units of its numbers.
    #[getter]
    fn control<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let control = self.frozen.control();
        let dict = as_dict(py, control)?;
        dict.set_item("rate_hz", control.rate_hz)?;
        Ok(dict)
    }

    /// The action for an observation and a goal, or the actions for a batch of them.
    #[pyo3(signature = (observation, goal=None))]
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        observation: &Bound<'py, PyAny>,
        goal: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let PolicyInfo { objects, action_dim: action, .. } = *self.frozen.info();
        let (batch, given) = self.read(observation, goal)?;
        if let Some(begun) = &self.begun
            && begun.goals.len() != given.goals.len()
        {
            let width = self.layout().width() * objects;
            let [begun, given] = [begun, &given].map(|it| it.goals.len() / width);
            return Err(InputError::new_err(format!(
                "{given} rows, but {begun} episodes have begun: expected as many as `begin` was \
                 given"
            )));
        }
        let actions = unlocked(py, || match objects {
            1 => self.act::<1>(&given),
            2 => self.act::<2>(&given),
            3 => self.act::<3>(&given),
            _ => Err(too_many(objects)),
        })??;
        let shape = [batch, vec![action]].concat();
        PyArray1::from_vec(py, actions).reshape(shape)
    }

    /// The actions as Stable-Baselines3 asks for them, and no state. It is the same action every time,
    /// whether that is asked for or not.
    #[pyo3(signature = (observation, state=None, episode_start=None, deterministic=true))]
    #[expect(unused_variables, reason = "the names are those of Stable-Baselines3")]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        observation: &Bound<'py, PyAny>,
        state: Option<&Bound<'py, PyAny>>,
        episode_start: Option<&Bound<'py, PyAny>>,
        deterministic: bool,
    ) -> PyResult<Bound<'py, PyTuple>> {
        (self.__call__(py, observation, None)?, py.None()).into_pyobject(py)
    }

    /// The policy for the episode that begins with this observation and goal, or for a batch of
    /// them: it places objects in the order that promises most, where the task allows every order.
    /// A policy that is called without it takes them as they are given.
    #[pyo3(signature = (observation, goal=None))]
    fn begin<'py>(
        &self,
        observation: &Bound<'py, PyAny>,
        goal: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Self> {
        let (_, begun) = self.read(observation, goal)?;
        let Self { frozen, places, .. } = self;
        Ok(Self { frozen: Arc::clone(frozen), places: places.clone(), begun: Some(begun) })
    }

    /// What unpickling and copying do.
    #[classmethod]
    #[pyo3(signature = (file, begun=None))]
    fn _from_bytes(cls: &Bound<'_, PyType>, file: &[u8], begun: Option<Parts>) -> PyResult<Self> {
        let path = Path::new("a pickled policy");
        let policy = unlocked(cls.py(), || CorePolicy::from_bytes(file, path))?;
        let policy = Self::new(policy.map_err(PolicyFailure)?)?;
        let begun =
            begun.map(|(observations, goals, achieved)| Given { observations, goals, achieved });
        Ok(Self { begun, ..policy })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let file = PyBytes::new(py, &slf.get().frozen.to_bytes());
        let begun = slf.get().begun.clone();
        let begun =
            begun.map(|Given { observations, goals, achieved }| (observations, goals, achieved));
        (slf.get_type().getattr("_from_bytes")?, (file, begun)).into_pyobject(py)
    }

    fn __repr__(&self) -> String {
        let PolicyInfo { task, objects, obs_dim: observation, action_dim: action, .. } =
            self.frozen.info();
        format!(
            "Policy(task='{task}', objects={objects}, observation={observation}, action={action})"
        )
    }
}

/// A [`Given`] that is pickled.
type Parts = (Vec<f32>, Vec<f32>, Option<Vec<f32>>);

/// What a batch of actions is chosen by.
#[derive(Clone)]
struct Given {
    observations: Vec<f32>,
    goals: Vec<f32>,
    /// None to find it in the observations.
    achieved: Option<Vec<f32>>,
}

impl Policy {
    /// The shape of a batch, and its rows.
    fn read<'py>(
        &self,
        observation: &Bound<'py, PyAny>,
        goal: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Vec<usize>, Given)> {
        let PolicyInfo { objects, obs_dim: width, .. } = *self.frozen.info();
        let mapping = observation.cast::<PyMapping>().ok();
        let item = |name| match &mapping {
            Some(mapping) if mapping.contains(name)? => mapping.get_item(name).map(Some),
            _ => Ok(None),
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
            let goals = read(what, goals, self.layout().width() * objects)?;
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
        Ok((batch, Given { observations, goals, achieved }))
    }

    /// How its goals lie in arrays.
    fn layout(&self) -> GoalLayout {
        GoalLayout { axes: self.places.axes, tail: *self.frozen.tail() }
    }

    /// What a row says: the scene, and what is asked for.
    fn scene<const N: usize>(
        &self,
        given: &Given,
        row: usize,
        leg: Leg,
    ) -> PyResult<(Achieved<N>, Desired<N>)> {
        let obs_dim = self.frozen.info().obs_dim;
        let observation = &given.observations[row * obs_dim..(row + 1) * obs_dim];
        let layout = self.layout();
        let width = layout.width() * N;
        let goal = row * width..(row + 1) * width;
        let wanted = &given.goals[goal.clone()];
        let reached = given.achieved.as_ref().map(|goals| &goals[goal]);
        let at = |place: usize| position(&observation[place..], layout.axes);
        let missing = |what| {
            InputError::new_err(format!(
                "{what} is not in the observation: expected the dictionary that the environment \
                 returns"
            ))
        };
        let targets = layout.positions::<N>(wanted);
        let objects = match (leg, targets) {
            // What is to be reached stays where it is.
            (Leg::Reach, Some(targets)) => targets,
            _ => {
                if let Some(objects) = reached.and_then(|row| layout.positions(row)) {
                    objects
                } else {
                    let places = self.places.objects.as_ref();
                    let places = places.ok_or_else(|| missing("where the objects are"))?;
                    std::array::from_fn(|object| at(places[object]))
                }
            }
        };
        let tails = match reached {
            Some(reached) => layout.tails(reached),
            None if layout.tail.is_none() => Tails::default(),
            None => return Err(missing("what the goal asks of the objects")),
        };
        let scene = Scene::new(at(self.places.gripper), objects).with_tails(tails);
        let desired = Desired::of_task(targets.unwrap_or(objects));
        Ok((Achieved(scene), desired.with_tails(layout.tails(wanted))))
    }

    /// The actions of the last sub-task, row by row.
    fn act<const N: usize>(&self, given: &Given) -> PyResult<Vec<f32>> {
        let PolicyInfo { obs_dim, action_dim, subtasks, .. } = *self.frozen.info();
        let mut spec = EnvSpec::<N> { subtasks, ..EnvSpec::new("", obs_dim, action_dim, 1) };
        spec.tolerances.tail = *self.frozen.tail();
        let unfit = |error| PolicyError::new_err(told(&error));
        let mut actor = self.frozen.actor(&spec).map_err(unfit)?;
        let stage = actor.task();
        let mut actions = vec![0.0; given.observations.len() / obs_dim * action_dim];
        for (row, action) in actions.chunks_exact_mut(action_dim).enumerate() {
            let observation = &given.observations[row * obs_dim..(row + 1) * obs_dim];
            let told = |error| InputError::new_err(format!("row {row}: {}", told(&error)));
            if let Some(begun) = &self.begun {
                let (start, desired) = self.scene::<N>(begun, row, stage.leg())?;
                actor.begin(&start, &desired).map_err(told)?;
            }
            let (scene, desired) = self.scene::<N>(given, row, stage.leg())?;
            actor.act(stage, observation, &scene, &desired, action).map_err(told)?;
            if let Some(limits) = &self.places.limits {
                limits.apply(action);
            }
        }
        Ok(actions)
    }
}

/// A Python dictionary with these fields.
fn as_dict<'py>(py: Python<'py>, fields: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    let json = serde_json::to_string(fields);
    let json = json.map_err(|error| InternalError::new_err(told(&error)))?;
    py.import("json")?.call_method1("loads", (json,))
}

fn too_many(objects: usize) -> PyErr {
    PolicyError::new_err(format!("the policy is for {objects} objects, expected 1 to 3"))
}
