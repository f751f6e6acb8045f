//! A run whose environment is known at run time only.

use rher_core::RunId;
use rher_core::config::{EngineKind, Precision, TrainConfig};
use rher_core::env::Env;
use rher_core::event::{Observer, Progress};
use rher_core::policy::Policy;
use rher_core::train::{Finish, Pretrained, TrainError, Trainer};
use rher_envs::{EnvVisitor, Simulated};
use rher_runs::{RunDir, RunFiles, RunFilesError};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// A [`Trainer`], whatever its environment.
pub(crate) trait AnyTrainer: Send {
    fn run(
        &mut self,
        folder: &Path,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<Finish, TrainError>;

    fn save(&mut self, folder: &Path) -> Result<(), TrainError>;

    fn set_env_steps(&mut self, env_steps: u64);

    fn set_until(&mut self, until: f32);

    fn config(&self) -> &TrainConfig;

    fn progress(&self) -> Progress;

    /// The files of its run, in a folder that was made for it or opened before it was resumed.
    fn files(&self, folder: RunDir) -> Result<RunFiles, RunFilesError>;

    fn id(&self) -> RunId;

    fn policy(&self) -> &Policy;
}

impl<const N: usize, E: Env<N> + 'static> AnyTrainer for Trainer<N, E> {
    fn run(
        &mut self,
        folder: &Path,
        observer: &mut dyn Observer,
        stop: &AtomicBool,
    ) -> Result<Finish, TrainError> {
        Self::run(self, Some(folder), observer, stop)
    }

    fn save(&mut self, folder: &Path) -> Result<(), TrainError> {
        Self::save(self, folder)
    }

    fn set_env_steps(&mut self, env_steps: u64) {
        Self::set_env_steps(self, env_steps);
    }

    fn set_until(&mut self, until: f32) {
        Self::set_until(self, until);
    }

    fn config(&self) -> &TrainConfig {
        Self::config(self)
    }

    fn progress(&self) -> Progress {
        Self::progress(self)
    }

    fn files(&self, folder: RunDir) -> Result<RunFiles, RunFilesError> {
        RunFiles::new(folder, self)
    }

    fn id(&self) -> RunId {
        Self::id(self)
    }

    fn policy(&self) -> &Policy {
        Self::policy(self)
    }
}

/// What a resumed run may have otherwise than before.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Changes {
    pub(crate) engine: Option<EngineKind>,
    pub(crate) precision: Option<Precision>,
}

/// Where a run begins.
pub(crate) enum Start {
    /// With nothing learned.
    New(Box<TrainConfig>),
    /// With what another run has learned.
    From(Box<Pretrained>, Box<TrainConfig>),
    /// At the last checkpoint in this folder, with what is changed.
    Resumed(PathBuf, Changes),
}

impl Start {
    /// The run of these environments.
    pub(crate) fn trainer<const N: usize, E: Env<N> + 'static>(
        self,
        envs: Vec<E>,
        workers: usize,
    ) -> Result<Box<dyn AnyTrainer>, TrainError> {
        Ok(match self {
            Self::New(config) => Box::new(Trainer::new(*config, envs, workers)?),
            Self::From(pretrained, config) => {
                Box::new(Trainer::new_from(&pretrained, *config, envs, workers)?)
            }
            Self::Resumed(folder, Changes { engine, precision }) => {
                Box::new(Trainer::resume_on(engine, precision, &folder, envs, workers)?)
            }
        })
    }
}

/// Makes a run of one of our tasks.
pub(crate) struct OfTask {
    pub(crate) start: Start,
    /// Environments between two updates.
    pub(crate) envs: usize,
    pub(crate) workers: usize,
}

impl EnvVisitor for OfTask {
    type Output = Result<Box<dyn AnyTrainer>, TrainError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { start, envs, workers } = self;
        let envs: Vec<E> = (0..envs.max(workers)).map(|_| build()).collect();
        start.trainer(envs, workers)
    }
}
