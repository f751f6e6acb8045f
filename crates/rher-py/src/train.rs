//! Runs, started from Python.

use crate::any_recorder::{self, Recorded};
use crate::any_trainer::{AnyTrainer, Changes, OfTask, Start};
use crate::calls::Calls;
use crate::error::{
    FileError, InputError, InternalError, SettingsError, StateError, told, unlocked,
};
use crate::foreign::{About, Foreign};
use crate::policy::Policy;
use crate::run_error::{
    from_checkpoint, from_files, from_run_dir, from_settings, from_train, from_write,
};
use crate::threads::allowed;
use crate::watch::{Beside, Told, Watch, watch};
use pyo3::prelude::*;
use pyo3::types::PyType;
use rher_core::config::{EngineKind, Method, Precision, Preset, TrainConfig};
use rher_core::train::checkpoint::{self, CheckpointError};
use rher_core::train::{Finish, TrainError as CoreTrainError};
use rher_envs::{Options, Task};
use rher_runs::{
    Asked, CONFIG_FILE, ConfigFile, ConfigFileError, EventFile, RunDir, RunFiles, Settings, State,
    list, read_pretrained, settings,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::num::NonZeroU64;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};

/// The settings that Python passes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Arguments {
    preset: Option<Preset>,
    config: Option<PathBuf>,
    set: BTreeMap<String, toml::Value>,
    method: Option<Method>,
    seed: Option<u64>,
    env_steps: Option<u64>,
    until: Option<f32>,
    engine: Option<EngineKind>,
    precision: Option<Precision>,
    envs: Option<u64>,
}

impl Changes {
    fn parse(json: &str) -> PyResult<Self> {
        serde_json::from_str(json).map_err(|error| SettingsError::new_err(told(&error)))
    }
}

impl Arguments {
    fn parse(json: &str) -> PyResult<Asked> {
        let Self { preset, config, set, method, seed, env_steps, until, engine, precision, envs } =
            serde_json::from_str(json).map_err(|error| SettingsError::new_err(told(&error)))?;
        let set = set.into_iter().collect();
        Ok(Asked { preset, config, set, method, seed, env_steps, until, engine, precision, envs })
    }
}

/// A run and its folder.
#[pyclass(frozen, module = "rher._rher")]
pub(crate) struct Trainer {
    folder: PathBuf,
    /// None once it is closed.
    session: Mutex<Option<Session>>,
}

type Sessions<'a> = MutexGuard<'a, Option<Session>>;

struct Session {
    /// None if it is on an environment of the user's.
    task: Option<Task>,
    trainer: Box<dyn AnyTrainer>,
    files: RunFiles,
    calls: Calls,
}

#[pymethods]
impl Trainer {
    /// A run of one of our tasks; `arguments` are JSON.
    #[classmethod]
    fn of_task(
        cls: &Bound<'_, PyType>,
        task: &str,
        arguments: &str,
        out: Option<PathBuf>,
        workers: Option<usize>,
        from_run: Option<PathBuf>,
    ) -> PyResult<Self> {
        let asked = Arguments::parse(arguments)?;
        let task: Task = task.parse().map_err(|error| InputError::new_err(told(&error)))?;
        let workers = threads(workers)?;
        unlocked(cls.py(), || {
            let Settings { config, options } =
                settings::resolve_here(task, &asked).map_err(from_settings)?;
            let path = out.unwrap_or_else(|| RunDir::default_path(&config));
            let envs = config.envs;
            let start = new_run(config, from_run)?;
            let trainer = task.visit_with(&options, OfTask { start, envs, workers });
            let trainer = trainer.map_err(|error| SettingsError::new_err(told(&error)))?;
            let trainer = trainer.map_err(|error| from_train(&error, None))?;
            let folder = RunDir::create(&path).map_err(from_run_dir)?;
            Self::ready(trainer, folder, Some(task), Calls::default())
        })?
    }

    /// A run on the user's environments, all like the first; `about` and `arguments` are JSON.
    #[classmethod]
    fn of_env(
        cls: &Bound<'_, PyType>,
        envs: Vec<Py<PyAny>>,
        about: &str,
        arguments: &str,
        out: Option<PathBuf>,
        workers: Option<usize>,
        from_run: Option<PathBuf>,
    ) -> PyResult<Self> {
        let asked = Arguments::parse(arguments)?;
        let about = parse_about(about)?;
        let workers = threads(workers)?;
        unlocked(cls.py(), || {
            let config = settings::resolve_foreign(&about.name, about.objects.max(1), &asked)
                .map_err(from_settings)?;
            let path = out.unwrap_or_else(|| RunDir::default_path(&config));
            let calls = Calls::default();
            let start = new_run(config, from_run)?;
            let trainer = on_foreign(envs, &about, start, workers, &calls)?;
            let folder = RunDir::create(&path).map_err(from_run_dir)?;
            Self::ready(trainer, folder, None, calls)
        })?
    }

    /// Continues a run: on `foreign` if it is of the user's environments.
    #[classmethod]
    fn resumed(
        cls: &Bound<'_, PyType>,
        folder: PathBuf,
        foreign: Option<(Vec<Py<PyAny>>, String)>,
        workers: Option<usize>,
        changes: &str,
    ) -> PyResult<Self> {
        let workers = threads(workers)?;
        let changes = Changes::parse(changes)?;
        unlocked(cls.py(), || {
            let folder = RunDir::open(&folder).map_err(from_run_dir)?;
            let checkpointed = |error: CheckpointError| from_checkpoint(&error);
            let config = checkpoint::read_config(folder.path()).map_err(checkpointed)?;
            let start = Start::Resumed(folder.path().to_owned(), changes);
            let calls = Calls::default();
            let (trainer, task) = if let Some((envs, about)) = foreign {
                let about = parse_about(&about)?;
                (on_foreign(envs, &about, start, workers, &calls)?, None)
            } else {
                let task: Task = config.task.parse().map_err(|_| {
                    InputError::new_err(format!(
                        "the run is of `{}`, your own environment: pass it as `env`",
                        config.task
                    ))
                })?;
                let variant = checkpoint::read_variant(folder.path()).map_err(checkpointed)?;
                let options = variant.parse().unwrap_or_else(|_| Options::of(task.options()));
                let visitor = OfTask { start, envs: config.envs, workers };
                let trainer = task.visit_with(&options, visitor);
                let trainer = trainer.map_err(|error| SettingsError::new_err(told(&error)))?;
                (trainer.map_err(|error| from_train(&error, None))?, Some(task))
            };
            Self::ready(trainer, folder, task, calls)
        })?
    }

    /// The folder of the run.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.folder.clone()
    }

    /// Name of the task or of the environment.
    #[getter]
    fn task(&self) -> PyResult<String> {
        Ok(open(&mut self.lock()?)?.trainer.config().task.clone())
    }

    /// Environment steps and success rate that end the run.
    #[getter]
    fn end(&self) -> PyResult<(u64, f32)> {
        let mut session = self.lock()?;
        let config = open(&mut session)?.trainer.config();
        Ok((config.env_steps, config.until))
    }

    /// Ends the run after other environment steps, or at another success rate.
    #[pyo3(signature = (env_steps=None, until=None))]
    fn set_end(&self, env_steps: Option<u64>, until: Option<f32>) -> PyResult<()> {
        let mut guard = self.lock()?;
        let session = open(&mut guard)?;
        if let Some(env_steps) = env_steps {
            session.trainer.set_env_steps(env_steps);
        }
        if let Some(until) = until {
            if !(0.0..=1.0).contains(&until) {
                return Err(SettingsError::new_err(format!("until is {until}, expected 0 to 1")));
            }
            session.trainer.set_until(until);
        }
        let Session { trainer, files, .. } = session;
        files.set_config(trainer.config()).map_err(from_run_dir)
    }

    /// Environment steps of training so far.
    #[getter]
    fn env_steps(&self) -> PyResult<u64> {
        Ok(open(&mut self.lock()?)?.trainer.progress().env_steps)
    }

    /// The policy as it is now.
    #[getter]
    fn policy(&self) -> PyResult<Policy> {
        Policy::new(open(&mut self.lock()?)?.trainer.policy().clone())
    }

    /// Releases the folder; the trainer cannot be used any more.
    fn close(&self) -> PyResult<()> {
        match self.lock()?.take() {
            Some(Session { files, .. }) => {
                files.close().map_err(|error| FileError::new_err(told(&error)))
            }
            None => Ok(()),
        }
    }

    /// Trains until the end of the run, or for `max_wall` seconds: `solved`, `steps-spent`,
    /// `stopped`.
    #[pyo3(signature = (
        on_event=None, max_wall=None, record_every=None, tensorboard=false
    ))]
    fn learn(
        &self,
        py: Python<'_>,
        on_event: Option<Py<PyAny>>,
        max_wall: Option<f64>,
        record_every: Option<NonZeroU64>,
        tensorboard: bool,
    ) -> PyResult<&'static str> {
        let end = match max_wall.map(Duration::try_from_secs_f64).transpose() {
            Ok(left) => left.map(|left| Instant::now() + left),
            Err(error) => return Err(InputError::new_err(format!("max_wall: {error}"))),
        };
        let mut guard = self.lock()?;
        let session = open(&mut guard)?;
        let beside = unlocked(py, || session.beside(record_every, tensorboard))??;
        let stop = AtomicBool::new(false);
        let calls = session.calls.clone();
        calls.allow();
        let (ran, watched) = unlocked(py, || {
            std::thread::scope(|scope| {
                let (tell, told) = channel();
                let training = scope.spawn(|| session.run(beside, &stop, tell));
                let watched = watch(&told, &stop, &calls, end, on_event.as_ref());
                (training.join(), watched)
            })
        })?;
        let Ok(ran) = ran else {
            return Err(InternalError::new_err("this is a bug in rher: the training panicked"));
        };
        watched?;
        Ok(match ran? {
            Finish::Solved => "solved",
            Finish::StepsSpent => "steps-spent",
            Finish::Stopped => "stopped",
        })
    }
}

fn open<'a>(session: &'a mut Sessions<'_>) -> PyResult<&'a mut Session> {
    session.as_mut().ok_or_else(|| StateError::new_err("the trainer is closed"))
}

impl Trainer {
    fn ready(
        trainer: Box<dyn AnyTrainer>,
        folder: RunDir,
        task: Option<Task>,
        calls: Calls,
    ) -> PyResult<Self> {
        let path = folder.path().to_owned();
        let files = trainer.files(folder).map_err(from_files)?;
        let session = Session { task, trainer, files, calls };
        Ok(Self { folder: path, session: Mutex::new(Some(session)) })
    }

    fn lock(&self) -> PyResult<Sessions<'_>> {
        match self.session.try_lock() {
            Ok(session) => Ok(session),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(StateError::new_err("the trainer is training")),
        }
    }
}

impl Session {
    /// Trains; what was learned before an environment failed is saved.
    fn run(&mut self, beside: Beside, stop: &AtomicBool, tell: Sender<Told>) -> PyResult<Finish> {
        let Self { trainer, files, calls, .. } = self;
        let path = files.path().to_owned();
        let mut watch = Watch { files, beside, tell };
        let ran = trainer.run(&path, &mut watch, stop);
        watch.finish();
        let error = match ran {
            Ok(finish) => return Ok(finish),
            Err(error) => error,
        };
        if let Err(gone) = files.folder().check() {
            return Err(from_run_dir(gone));
        }
        let raised = calls.take_raised();
        if matches!(error, CoreTrainError::Rollout { .. } | CoreTrainError::Evaluate { .. }) {
            trainer.save(&path).map_err(|error| from_train(&error, None))?;
            if calls.is_interrupted() {
                return Ok(Finish::Stopped);
            }
        }
        Err(from_train(&error, raised))
    }

    /// The files that are written beside the metrics.
    fn beside(&mut self, record_every: Option<NonZeroU64>, tensorboard: bool) -> PyResult<Beside> {
        let Self { trainer, files, task, .. } = self;
        let (folder, settings) = (files.path(), files.settings());
        let recorder = match (record_every, task) {
            (Some(every), Some(task)) => {
                let recorded = Recorded { every, folder, run: trainer.id(), settings };
                let recorder = any_recorder::build(*task, recorded);
                let recorder = recorder.map_err(|error| SettingsError::new_err(told(&error)))?;
                Some(recorder.map_err(from_settings)?)
            }
            (Some(_), None) => {
                return Err(InputError::new_err(
                    "record_every is for tasks of this package: an environment of yours cannot be \
                     simulated again",
                ));
            }
            (None, _) => None,
        };
        let started_at = trainer.progress().env_steps;
        let events = tensorboard.then(|| EventFile::create(folder, started_at));
        let events = events.transpose().map_err(|error| from_write(&error))?;
        Ok(Beside { recorder, events })
    }
}

/// The settings of a run, as JSON.
#[pyfunction]
pub(crate) fn run_settings(folder: PathBuf) -> PyResult<String> {
    let path = folder.join(CONFIG_FILE);
    let file = ConfigFile::read(&folder).map_err(|error| match error {
        ConfigFileError::File(error) => FileError::new_err(told(&error)),
        error @ ConfigFileError::Damaged { .. } => SettingsError::new_err(told(&error)),
    })?;
    let file = file.ok_or_else(|| {
        FileError::new_err(format!("cannot read `{}`: there is no such file", path.display()))
    })?;
    serde_json::to_string(&file.into_table()).map_err(|error| SettingsError::new_err(told(&error)))
}

/// Whether a run goes on: `running`, `solved`, `spent` or `stopped`.
#[pyfunction]
pub(crate) fn run_state(folder: PathBuf) -> PyResult<&'static str> {
    let listed = list(&folder).map_err(|error| from_write(&error))?;
    let Some(listed) = listed.into_iter().next() else {
        return Err(FileError::new_err(format!("`{}` holds no run", folder.display())));
    };
    Ok(match listed.map_err(|error| FileError::new_err(told(&error)))?.state {
        State::Running => "running",
        State::Solved => "solved",
        State::Spent => "spent",
        State::Stopped => "stopped",
    })
}

fn parse_about(json: &str) -> PyResult<About> {
    serde_json::from_str(json).map_err(|error| InputError::new_err(told(&error)))
}

/// A run with these settings, which starts from the one in a folder if there is one.
fn new_run(config: TrainConfig, from_run: Option<PathBuf>) -> PyResult<Start> {
    let config = Box::new(config);
    Ok(match from_run {
        None => Start::New(config),
        Some(folder) => {
            let pretrained =
                read_pretrained(&folder).map_err(|error| from_train(&error.into(), None))?;
            Start::From(Box::new(pretrained), config)
        }
    })
}

/// A run on the user's environments.
fn on_foreign(
    envs: Vec<Py<PyAny>>,
    about: &About,
    start: Start,
    workers: usize,
    calls: &Calls,
) -> PyResult<Box<dyn AnyTrainer>> {
    let trainer = match about.objects {
        0 | 1 => start.trainer(Foreign::<1>::all(envs, about, calls)?, workers),
        2 => start.trainer(Foreign::<2>::all(envs, about, calls)?, workers),
        3 => start.trainer(Foreign::<3>::all(envs, about, calls)?, workers),
        objects => {
            return Err(InputError::new_err(format!("objects is {objects}, expected 0 to 3")));
        }
    };
    trainer.map_err(|error| from_train(&error, None))
}

/// As many threads as were asked for, or as this process may use.
fn threads(asked: Option<usize>) -> PyResult<usize> {
    match asked {
        Some(0) => Err(InputError::new_err("workers is 0, expected at least 1")),
        Some(workers) => Ok(workers),
        None => Ok(allowed()),
    }
}
