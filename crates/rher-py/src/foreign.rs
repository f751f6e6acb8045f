//! An environment that someone else wrote in Python, as the learner sees it.

use crate::arrays::read_as_is;
use crate::calls::Calls;
use crate::error::{InputError, told};
use crate::goals::{GoalLayout, position};
use crate::places::Places;
use numpy::PyArray1;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rher_core::Names;
use rher_core::env::{End, Env, EnvError, EnvSpec, Start};
use rher_core::goal::{
    Achieved, Desired, EncodedGoal, Metric, Position, Scene, TailPart, TailSpec, Tolerances,
};
use std::array;

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
    /// Whether goals say where objects should be.
    pub(crate) has_positions: bool,
    /// What else they say.
    pub(crate) tail: Vec<Part>,
    pub(crate) places: Places,
}

/// What goals say of an object beside its position.
#[derive(Clone, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Part {
    name: String,
    metric: Metric,
    tolerance: f32,
}

impl About {
    fn tail(&self) -> PyResult<TailSpec> {
        let part = |Part { metric, tolerance, .. }: &Part| TailPart {
            metric: *metric,
            tolerance: *tolerance,
        };
        let parts: Vec<TailPart> = self.tail.iter().map(part).collect();
        let spec = if self.has_positions {
            TailSpec::beside_positions(&parts)
        } else {
            TailSpec::instead_of_positions(&parts)
        };
        spec.map_err(|error| InputError::new_err(format!("tail: {}", told(&error))))
    }
}

/// A Gymnasium environment with dictionaries of `observation`, `achieved_goal`, `desired_goal`.
pub(crate) struct Foreign<const N: usize> {
    env: Py<PyAny>,
    spec: EnvSpec<N>,
    places: Places,
    layout: GoalLayout,
    /// Whether its goal is a place for the gripper.
    is_reach: bool,
    /// What this episode asks for.
    desired: Desired<N>,
    /// How it ended.
    end: Option<End>,
    /// What it returned last; kept to save allocations.
    seen: Seen,
    calls: Calls,
}

impl<const N: usize> Foreign<N> {
    /// Environments that are all like this.
    pub(crate) fn all(envs: Vec<Py<PyAny>>, about: &About, calls: &Calls) -> PyResult<Vec<Self>> {
        envs.into_iter().map(|env| Self::new(env, about, calls.clone())).collect()
    }

    fn new(env: Py<PyAny>, about: &About, calls: Calls) -> PyResult<Self> {
        let About { name, objects, observation, action, episode_steps, tolerance, .. } = about;
        let (tail, places) = (about.tail()?, &about.places);
        if !tail.has_positions() && places.objects.as_ref().is_none_or(|it| it.len() != N) {
            return Err(InputError::new_err(format!(
                "goals have no positions, so `positions` has to say where those of {N} objects are"
            )));
        }
        let variant = serde_json::to_string(places);
        let is_reach = *objects == 0;
        let spec = EnvSpec {
            variant: variant.map_err(|error| InputError::new_err(told(&error)))?,
            subtasks: if is_reach { 1 } else { 2 * N },
            tolerances: Tolerances { tail, ..Tolerances::uniform(*tolerance) },
            mirrors: places.symmetries.mirrors(),
            permutations: places.symmetries.permutations()?,
            names: Names {
                tail: about.tail.iter().map(|part| part.name.clone()).collect(),
                ..Names::default()
            },
            ..EnvSpec::new(name, *observation, *action, *episode_steps)
        };
        let desired = Desired::of_task([Position::origin(); N]);
        let (places, layout) = (places.clone(), GoalLayout { axes: places.axes, tail });
        let (end, seen) = (None, Seen::default());
        Ok(Self { env, spec, places, layout, is_reach, desired, end, seen, calls })
    }

    /// The position of the observation that Python returned last.
    fn observed(&self, place: usize) -> Position {
        position(&self.seen.observation[place..], self.layout.axes)
    }

    /// Where the objects are in it, where goals do not say that.
    fn observed_objects(&self) -> [Position; N] {
        let places = self.places.objects.as_deref().unwrap_or_default();
        array::from_fn(|object| self.observed(places[object]))
    }

    /// What the episode asks for that begins with what Python returned last.
    fn wanted(&self) -> Desired<N> {
        let Self { seen: Seen { desired, .. }, layout, .. } = self;
        let targets = layout.positions(desired).unwrap_or_else(|| self.observed_objects());
        Desired::of_task(targets).with_tails(layout.tails(desired))
    }

    /// What Python returned last, in this episode.
    fn scene(&self, observation: &mut [f32]) -> Achieved<N> {
        let Self { seen: Seen { observation: seen, achieved, .. }, layout, .. } = self;
        observation.copy_from_slice(seen);
        let objects = if self.is_reach {
            // What is to be reached stays where it is.
            *self.desired.objects()
        } else {
            layout.positions(achieved).unwrap_or_else(|| self.observed_objects())
        };
        let gripper = self.observed(self.places.gripper);
        Achieved(Scene::new(gripper, objects).with_tails(layout.tails(achieved)))
    }

    /// Whether the task is done at the end of an episode, as far as the goals tell.
    fn is_solved(&self, achieved: &Achieved<N>) -> bool {
        let goal = EncodedGoal::new(self.spec.last_stage(), achieved, &self.desired);
        goal.is_met(achieved, &self.spec.tolerances)
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

/// How a step ended an episode, as Gymnasium has it.
enum Ended {
    /// `terminated`, and whether that was a success where the environment says so.
    Terminated(Option<bool>),
    /// `truncated`.
    Truncated,
}

impl Ended {
    /// Reads what a step returned.
    fn read(result: &Bound<'_, PyAny>) -> PyResult<Option<Self>> {
        if result.get_item(2)?.is_truthy()? {
            let info = result.get_item(4)?;
            let Ok(info) = info.cast::<PyDict>() else { return Ok(Some(Self::Terminated(None))) };
            let success = match info.get_item("is_success")? {
                Some(success) => Some(success),
                None => info.get_item("success")?,
            };
            let success = success.map(|success| success.is_truthy()).transpose()?;
            return Ok(Some(Self::Terminated(success)));
        }
        Ok(result.get_item(3)?.is_truthy()?.then_some(Self::Truncated))
    }
}

impl<const N: usize> Env<N> for Foreign<N> {
    fn spec(&self) -> &EnvSpec<N> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        // Some environments take no larger seeds.
        let seed = seed & 0x7fff_ffff;
        let Self { env, seen, layout, calls, .. } = self;
        calls.call(|py| {
            let arguments = PyDict::new(py);
            arguments.set_item(intern!(py, "seed"), seed)?;
            let result = env.bind(py).call_method(intern!(py, "reset"), (), Some(&arguments))?;
            seen.read(&result.get_item(0)?, observation.len(), layout.width() * N)
        })?;
        self.end = None;
        self.desired = self.wanted();
        let achieved = self.scene(observation);
        Ok(Start { achieved, desired: self.desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let Self { env, seen, layout, calls, places, .. } = self;
        let ended = calls.call(|py| {
            let mut action = action.to_vec();
            if let Some(limits) = &places.limits {
                limits.apply(&mut action);
            }
            let action = PyArray1::from_vec(py, action);
            let result = env.bind(py).call_method1(intern!(py, "step"), (action,))?;
            seen.read(&result.get_item(0)?, observation.len(), layout.width() * N)?;
            Ended::read(&result)
        })?;
        let achieved = self.scene(observation);
        self.end = ended.map(|ended| match ended {
            Ended::Truncated => End::Truncated,
            Ended::Terminated(success) => {
                let is_solved = success.unwrap_or_else(|| self.is_solved(&achieved));
                if is_solved { End::Solved } else { End::Failed }
            }
        });
        Ok(achieved)
    }

    fn end(&self) -> Option<End> {
        self.end
    }
}
