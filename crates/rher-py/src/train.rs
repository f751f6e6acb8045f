//! Runs, started from Python.

use crate::any_trainer::{AnyTrainer, OfTask, Start};
use crate::error::{
    EnvError, FileError, InputError, InternalError, PolicyError, SettingsError, StateError,
    TrainError, told, unlocked,
};
use crate::foreign::{About, Foreign, Raised};
use crate::policy::Policy;
use crate::threads::allowed;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use rher_core::config::{Method, Preset, TrainConfig};
use rher_core::event::{Event, ObserverError, Progress};
use rher_core::files::FileError as CoreFileError;
use rher_core::policy::PolicyError as CorePolicyError;
use rher_core::train::checkpoint::{self, CheckpointError};
use rher_core::train::{Finish, PretrainedError, TrainError as CoreTrainError};
use rher_envs::{Options, Task};
use rher_runs::{
    Asked, CONFIG_FILE, ConfigFile, ConfigFileError, MetricsError, MetricsFile, RunDir,
    RunDirError, Settings, SettingsError as CoreSettingsError, read_pretrained, settings,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

/// How often Python may handle signals during a run.
const SIGNALS: Duration = Duration::from_millis(50);

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
}

impl Arguments {
    fn parse(json: &str) -> PyResult<Asked> {
        let Self { preset, config, set, method, seed, env_steps, until } =
            serde_json::from_str(json).map_err(|error| SettingsError::new_err(told(&error)))?;
        let set = set.into_iter().collect();
        let (engine, precision, envs) = (None, None, None);
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
    trainer: Box<dyn AnyTrainer>,
    folder: RunDir,
    metrics: MetricsFile,
    raised: Raised,
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
            Self::begun(trainer, folder, options, Raised::default())
        })?
    }

    /// A run on the user's environment; `about` and `arguments` are JSON.
    #[classmethod]
    fn of_env(
        cls: &Bound<'_, PyType>,
        env: Py<PyAny>,
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
            let raised = Raised::default();
            let start = new_run(config, from_run)?;
            let trainer = on_foreign(env, &about, start, workers, &raised)?;
            let folder = RunDir::create(&path).map_err(from_run_dir)?;
            Self::begun(trainer, folder, Options::default(), raised)
        })?
    }

    /// Continues a run: on `foreign` if it is of the user's environment.
    #[classmethod]
    fn resumed(
        cls: &Bound<'_, PyType>,
        folder: PathBuf,
        foreign: Option<(Py<PyAny>, String)>,
        workers: Option<usize>,
    ) -> PyResult<Self> {
        let workers = threads(workers)?;
        unlocked(cls.py(), || {
            let folder = RunDir::open(&folder).map_err(from_run_dir)?;
            let checkpointed = |error: CheckpointError| from_checkpoint(&error);
            let config = checkpoint::read_config(folder.path()).map_err(checkpointed)?;
            let start = Start::Resumed(folder.path().to_owned());
            let raised = Raised::default();
            let (trainer, options) = if let Some((env, about)) = foreign {
                let about = parse_about(&about)?;
                (on_foreign(env, &about, start, workers, &raised)?, Options::default())
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
                (trainer.map_err(|error| from_train(&error, None))?, options)
            };
            let metrics =
                MetricsFile::resume(&folder.metrics(), trainer.id(), trainer.evaluations())
                    .map_err(|error| from_metrics(&error))?;
            Self::ready(trainer, folder, options, raised, metrics)
        })?
    }

    /// The folder of the run.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.folder.clone()
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
            Some(Session { folder, .. }) => {
                folder.close().map_err(|error| FileError::new_err(told(&error)))
            }
            None => Ok(()),
        }
    }

    /// Trains until the end of the run: `solved`, `steps-spent`.
    #[pyo3(signature = (env_steps=None, until=None, on_event=None))]
    fn learn(
        &self,
        py: Python<'_>,
        env_steps: Option<u64>,
        until: Option<f32>,
        on_event: Option<Py<PyAny>>,
    ) -> PyResult<&'static str> {
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
        let stop = AtomicBool::new(false);
        let (ran, watched) = unlocked(py, || {
            std::thread::scope(|scope| {
                let (tell, told) = channel();
                let training = scope.spawn(|| {
                    session.run(&stop, move |event| {
                        let _ = tell.send(event.clone());
                    })
                });
                let watched = watch(&told, &stop, on_event.as_ref());
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
    fn begun(
        trainer: Box<dyn AnyTrainer>,
        folder: RunDir,
        options: Options,
        raised: Raised,
    ) -> PyResult<Self> {
        let metrics = MetricsFile::create(&folder.metrics(), trainer.id());
        let metrics = metrics.map_err(|error| from_write(&error))?;
        Self::ready(trainer, folder, options, raised, metrics)
    }

    fn ready(
        trainer: Box<dyn AnyTrainer>,
        folder: RunDir,
        options: Options,
        raised: Raised,
        metrics: MetricsFile,
    ) -> PyResult<Self> {
        let config = trainer.config().clone();
        folder.write_config(&Settings { config, options }, trainer.id()).map_err(from_run_dir)?;
        let path = folder.path().to_owned();
        let session = Session { trainer, folder, metrics, raised };
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
    fn run(&mut self, stop: &AtomicBool, tell: impl Fn(&Event)) -> PyResult<Finish> {
        let Self { trainer, folder, metrics, raised } = self;
        let mut observer = |event: &Event| {
            if matches!(event, Event::Evaluated(_) | Event::Saving) {
                folder.check().map_err(|error| ObserverError(error.into()))?;
            }
            if let Event::Evaluated(line) = event {
                metrics.append(line).map_err(|error| ObserverError(error.into()))?;
            }
            // Python hears of what is saved, not of what is about to be.
            if !matches!(event, Event::Saving) {
                tell(event);
            }
            Ok(())
        };
        let error = match trainer.run(folder.path(), &mut observer, stop) {
            Ok(finish) => return Ok(finish),
            Err(error) => error,
        };
        if let Err(gone) = folder.check() {
            return Err(from_run_dir(gone));
        }
        let raised = raised.lock().unwrap_or_else(PoisonError::into_inner).take();
        if matches!(error, CoreTrainError::Rollout { .. } | CoreTrainError::Evaluate { .. }) {
            trainer.save(folder.path()).map_err(|error| from_train(&error, None))?;
        }
        Err(from_train(&error, raised))
    }
}

/// Tells Python of events, and lets it handle signals, until the run is over. An exception of
/// either stops the run.
fn watch(told: &Receiver<Event>, stop: &AtomicBool, on_event: Option<&Py<PyAny>>) -> PyResult<()> {
    let mut watched = Ok(());
    loop {
        let event = match told.recv_timeout(SIGNALS) {
            Ok(event) => Some(event),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return watched,
        };
        let handled = Python::attach(|py| {
            py.check_signals()?;
            if let (Some(event), Some(on_event), Ok(())) = (event, on_event, &watched) {
                on_event.call1(py, (as_dict(py, &event)?,))?;
            }
            PyResult::Ok(())
        });
        if let Err(error) = handled {
            stop.store(true, Ordering::Relaxed);
            watched = Err(error);
        }
    }
}

/// An event as a Python dictionary.
fn as_dict<'py>(py: Python<'py>, event: &Event) -> PyResult<Bound<'py, PyDict>> {
    let (kind, dict) = match event {
        Event::Progress(Progress { env_steps, episodes, updates }) => {
            let dict = PyDict::new(py);
            dict.set_item("env_steps", env_steps)?;
            dict.set_item("episodes", episodes)?;
            dict.set_item("updates", updates)?;
            ("progress", dict)
        }
        Event::Evaluated(metrics) => {
            let json = serde_json::to_string(metrics);
            let json = json.map_err(|error| InternalError::new_err(told(&error)))?;
            let dict = py.import("json")?.call_method1("loads", (json,))?;
            ("evaluated", dict.cast_into::<PyDict>()?)
        }
        // Nobody asks for these here.
        Event::Explored(script) => {
            let dict = PyDict::new(py);
            dict.set_item("episode", script.number)?;
            dict.set_item("seed", script.seed)?;
            ("explored", dict)
        }
        Event::Saved => ("saved", PyDict::new(py)),
        _ => ("other", PyDict::new(py)),
    };
    dict.set_item("kind", kind)?;
    Ok(dict)
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

/// A run on the user's environment.
fn on_foreign(
    env: Py<PyAny>,
    about: &About,
    start: Start,
    workers: usize,
    raised: &Raised,
) -> PyResult<Box<dyn AnyTrainer>> {
    let raised = raised.clone();
    let trainer = match about.objects {
        0 | 1 => start.trainer(vec![Foreign::<1>::new(env, about, raised)?], workers),
        2 => start.trainer(vec![Foreign::<2>::new(env, about, raised)?], workers),
        3 => start.trainer(vec![Foreign::<3>::new(env, about, raised)?], workers),
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

fn from_settings(error: CoreSettingsError) -> PyErr {
    let text = told(&error);
    // Its words are those of the command line.
    let text = text.trim_start_matches("--");
    SettingsError::new_err(match &error {
        CoreSettingsError::Unknown { nearest: Some(nearest), .. } => {
            format!("{text}; did you mean `{nearest}`?")
        }
        _ => text.to_owned(),
    })
}

fn from_run_dir(error: RunDirError) -> PyErr {
    match error {
        RunDirError::Settings(error) => from_settings(error),
        RunDirError::Exists { .. } => {
            FileError::new_err(format!("{error}: resume it, or give another folder as `out`"))
        }
        RunDirError::InUse { path } => FileError::new_err(format!(
            "`{}` is in use by another process, or by a trainer that was not closed",
            path.display()
        )),
        error => FileError::new_err(told(&error)),
    }
}

fn from_write(error: &CoreFileError) -> PyErr {
    FileError::new_err(told(error))
}

fn from_metrics(error: &MetricsError) -> PyErr {
    FileError::new_err(told(error))
}

fn from_checkpoint(error: &CheckpointError) -> PyErr {
    match error {
        CheckpointError::Policy(CorePolicyError::Malformed { .. }) => {
            PolicyError::new_err(told(error))
        }
        CheckpointError::Mismatch { .. } => InputError::new_err(told(error)),
        _ => FileError::new_err(told(error)),
    }
}

/// What stopped a run; `raised` is what the user's environment raised.
fn from_train(error: &CoreTrainError, raised: Option<PyErr>) -> PyErr {
    match error {
        CoreTrainError::Rollout { .. } | CoreTrainError::Evaluate { .. } => {
            let told = EnvError::new_err(format!("{}; progress was saved", told(error)));
            Python::attach(|py| told.set_cause(py, raised));
            told
        }
        CoreTrainError::Config(_)
        | CoreTrainError::Memory(_)
        | CoreTrainError::Engine(_)
        | CoreTrainError::Spec(_)
        | CoreTrainError::OtherObjects { .. }
        | CoreTrainError::Pretrained(PretrainedError::Unfit { .. })
        | CoreTrainError::TooFewEnvs { .. } => SettingsError::new_err(told(error)),
        CoreTrainError::Pretrained(PretrainedError::Checkpoint(error))
        | CoreTrainError::Checkpoint(error) => from_checkpoint(error),
        CoreTrainError::Pretrained(PretrainedError::NoCheckpoint { .. }) => {
            FileError::new_err(told(error))
        }
        CoreTrainError::Observer(_) => FileError::new_err(told(error)),
        _ => TrainError::new_err(told(error)),
    }
}
