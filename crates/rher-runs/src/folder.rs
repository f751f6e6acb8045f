//! A run's folder: where it is, who may write in it, and what lies where.

use crate::machine::Machine;
use crate::settings::{self, Settings, SettingsError};
use rher_core::config::TrainConfig;
use rher_core::files::{self, FileError};
use rher_core::train::checkpoint::{self, CheckpointError, POLICY_FILE};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::process;

/// The settings of a run.
pub const CONFIG_FILE: &str = "config.toml";
/// One line for each evaluation.
pub const METRICS_FILE: &str = "metrics.jsonl";
const LOCK_FILE: &str = ".lock";

/// The folder of a run, locked for as long as this value lives.
///
/// The lock is the operating system's, so it dies with the process.
#[derive(Debug)]
pub struct RunDir {
    path: PathBuf,
    lock: File,
    /// The process that holds the lock: a forked one only has a copy of it.
    process: u32,
}

impl RunDir {
    /// `runs/<task>-<method>-<preset>-<seed>`: runs that differ in nothing else share a name, and
    /// the second one is refused rather than written over the first.
    pub fn default_path(config: &TrainConfig) -> PathBuf {
        let TrainConfig { task, relay, preset, seed, .. } = config;
        let (method, preset) = (relay.method.name(), preset.name());
        Path::new("runs").join(format!("{task}-{method}-{preset}-{seed}"))
    }

    /// Makes the folder of a new run, with a note of the machine that makes it.
    pub fn create(path: &Path) -> Result<Self, RunDirError> {
        std::fs::create_dir_all(path).map_err(FileError::write(path))?;
        let folder = Self::lock(path)?;
        // Someone may have deleted the checkpoint and kept the policy.
        if holds_checkpoint(path) || path.join(POLICY_FILE).exists() {
            return Err(RunDirError::Exists { path: path.to_owned() });
        }
        Machine::here().write(path)?;
        Ok(folder)
    }

    /// Opens the folder of a run that was made before.
    pub fn open(path: &Path) -> Result<Self, RunDirError> {
        if holds_checkpoint(path) {
            Self::lock(path)
        } else {
            Err(RunDirError::NoRun { path: path.to_owned() })
        }
    }

    fn lock(path: &Path) -> Result<Self, RunDirError> {
        let lock_path = path.join(LOCK_FILE);
        let lock = File::create(&lock_path).map_err(FileError::write(&lock_path))?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { path: path.to_owned(), lock, process: process::id() }),
            Err(TryLockError::WouldBlock) => Err(RunDirError::InUse { path: path.to_owned() }),
            Err(TryLockError::Error(error)) => Err(FileError::write(&lock_path)(error).into()),
        }
    }

    /// Gives the lock back although forked processes may still have copies of it; does nothing in a
    /// forked process itself.
    pub fn close(self) -> Result<(), FileError> {
        let Self { path, lock, process } = self;
        if process != process::id() {
            return Ok(());
        }
        lock.unlock().map_err(FileError::write(&path))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// One line for each evaluation.
    pub fn metrics(&self) -> PathBuf {
        self.path.join(METRICS_FILE)
    }

    /// The policy alone.
    pub fn policy(&self) -> PathBuf {
        self.path.join(POLICY_FILE)
    }

    /// Writes the settings; the file is complete or not there.
    pub fn write_config(&self, settings: &Settings) -> Result<(), RunDirError> {
        let path = self.path.join(CONFIG_FILE);
        files::replace(&path, settings::to_toml(settings)?.as_bytes())?;
        Ok(())
    }
}

/// The settings that were kept with a run, if they can be read.
pub fn read_config(folder: &Path) -> Option<Settings> {
    settings::from_toml(&settings::read_text(&folder.join(CONFIG_FILE)).ok()?)
}

/// The first checkpoint is written before the first step, so without one nothing was done.
fn holds_checkpoint(path: &Path) -> bool {
    !matches!(checkpoint::read_config(path), Err(CheckpointError::Missing { .. }))
}

/// A run folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RunDirError {
    /// Another process writes in it.
    #[error("`{}` is in use by another process", path.display())]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// A new run would write over it.
    #[error("`{}` already holds a run", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// There is nothing to go on with.
    #[error("`{}` holds no run", path.display())]
    NoRun {
        /// The folder.
        path: PathBuf,
    },
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// The settings cannot be written down.
    #[error(transparent)]
    Settings(#[from] SettingsError),
}
