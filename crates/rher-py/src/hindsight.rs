//! What `python -m rher.compare` measures: the drawing of relabeled samples.

use crate::error::{InputError, InternalError, told, unlocked};
use crate::made::parse;
use pyo3::prelude::*;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::Preset;
use rher_core::episode::{RolloutError, rollout};
use rher_core::goal::Stage;
use rher_core::input::InputEncoder;
use rher_core::relabel::Relabeler;
use rher_core::replay::Replay;
use rher_core::seed::{Purpose, Seed};
use rher_envs::{EnvVisitor, Simulated};
use std::sync::{Mutex, PoisonError};

/// A replay of random episodes, with the settings of the preset `paper`: no sample is mirrored,
/// since the other packages mirror none.
#[pyclass(frozen, module = "rher._rher")]
pub(crate) struct Hindsight(Mutex<Box<dyn Sampler>>);

#[pymethods]
impl Hindsight {
    /// Plays this many episodes of `task`.
    #[new]
    fn new(py: Python<'_>, task: &str, episodes: u64) -> PyResult<Self> {
        let (task, options) = parse(task, "{}")?;
        let played = unlocked(py, || task.visit_with(&options, Play { episodes }))?;
        let played = played.map_err(|error| InputError::new_err(told(&error)))?;
        let sampler = played.map_err(|error| InternalError::new_err(told(&error)))?;
        Ok(Self(Mutex::new(sampler)))
    }

    /// Draws `batches` of `rows` samples of the last sub-task, relabeled, normalized and encoded
    /// for the networks; returns how many of them are rewarded.
    fn sample(&self, py: Python<'_>, batches: usize, rows: usize) -> PyResult<usize> {
        unlocked(py, || {
            let mut sampler = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            sampler.sample(batches, rows)
        })
    }
}

/// Draws samples, however many objects they have.
trait Sampler: Send {
    fn sample(&mut self, batches: usize, rows: usize) -> usize;
}

struct Play {
    episodes: u64,
}

impl EnvVisitor for Play {
    type Output = Result<Box<dyn Sampler>, RolloutError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let mut env = build();
        let spec = env.spec().clone();
        let config = Preset::Paper.config(&spec.name, N);
        let mut replay = Replay::new(&spec, self.episodes as usize * spec.episode_steps);
        let mut encoder = InputEncoder::new(&config.relay, &spec);
        let relabeler = Relabeler::new(&config.relay, &spec);
        let stages: Vec<Stage<N>> = Stage::all().take(spec.subtasks).collect();
        for count in 0..self.episodes {
            let mut rng = Seed(0).stream(Purpose::Exploration, count);
            let seed = Seed(0).episode(Purpose::Environment, count);
            let episode = rollout(&mut env, seed, |_, action| {
                action.fill_with(|| rng.random_range(-1.0..=1.0));
                Ok(())
            })?;
            relabeler.observe(&episode, &stages, &mut encoder, &mut rng);
            replay.push(&episode);
        }
        let action = spec.action_dim;
        let rng = Seed(0).stream(Purpose::Batch, 0);
        let last = spec.last_stage();
        Ok(Box::new(Random { replay, encoder, relabeler, last, action, rng }))
    }
}

/// Random episodes, and what draws from them.
struct Random<const N: usize> {
    replay: Replay<N>,
    encoder: InputEncoder,
    relabeler: Relabeler<N>,
    last: Stage<N>,
    action: usize,
    rng: ChaCha8Rng,
}

impl<const N: usize> Sampler for Random<N> {
    fn sample(&mut self, batches: usize, rows: usize) -> usize {
        let Self { replay, encoder, relabeler, last, action, rng } = self;
        let mut batch = Batch::zeros(rows, encoder.width(), *action);
        let mut draw = || relabeler.draw(replay, encoder, *last, &mut batch, 0..rows, rng);
        (0..batches).map(|_| draw()).sum()
    }
}
