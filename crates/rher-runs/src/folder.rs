//! A run's folder: where it is, who may write in it, and what lies where.

use crate::config_file::{self, CONFIG_FILE};
use crate::machine::Machine;
use crate::metrics::METRICS_FILE;
use crate::settings::{Settings, SettingsError};
use rher_core::RunId;
use rher_core::config::TrainConfig;
use rher_core::files::{self, FileError};
use rher_core::train::checkpoint::{self, CHECKPOINT_FOLDER, CheckpointError, POLICY_FILE};
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::process;

const LOCK_FILE: &str = ".lock";

/// The folder of a run, locked for as long as this value lives.
///
/// The lock is the operating system's, so it dies with the process. Where the file system has no
/// locks, nothing keeps another process out.
#[derive(Debug)]
pub struct RunDir {
    path: PathBuf,
    lock: File,
    is_guarded: bool,
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

    /// Makes the folder of a new run, with a note of the machine that makes it, and removes what a
    /// killed process left unfinished in it.
    pub fn create(path: &Path) -> Result<Self, RunDirError> {
        std::fs::create_dir_all(path).map_err(FileError::write(path))?;
        let folder = Self::lock(path)?;
        // Someone may have deleted the checkpoint and kept the policy.
        if holds_checkpoint(path)? || path.join(POLICY_FILE).exists() {
            return Err(RunDirError::Exists { path: path.to_owned() });
        }
        folder.remove_unfinished()?;
        Machine::here().write(path)?;
        Ok(folder)
    }

    /// Opens the folder of a run that was made before, and removes what a killed process left
    /// unfinished in it.
    pub fn open(path: &Path) -> Result<Self, RunDirError> {
        if !holds_checkpoint(path)? {
            return Err(RunDirError::NoRun { path: path.to_owned() });
        }
        let folder = Self::lock(path)?;
        folder.remove_unfinished()?;
        Ok(folder)
    }

    /// Removes what a killed process left, unless another one may be writing it.
    fn remove_unfinished(&self) -> Result<(), FileError> {
        let folders = [self.path.clone(), self.path.join(CHECKPOINT_FOLDER)];
        let there = folders.iter().filter(|folder| self.is_guarded && folder.is_dir());
        there.map(PathBuf::as_path).try_for_each(files::remove_unfinished)
    }

    fn lock(path: &Path) -> Result<Self, RunDirError> {
        let lock_path = path.join(LOCK_FILE);
        let lock = File::create(&lock_path).map_err(FileError::write(&lock_path))?;
        let is_guarded = match lock.try_lock() {
            Ok(()) => true,
            Err(TryLockError::WouldBlock) => {
                return Err(RunDirError::InUse { path: path.to_owned() });
            }
            Err(TryLockError::Error(error)) if has_no_locks(&error) => false,
            Err(TryLockError::Error(error)) => {
                return Err(FileError::write(&lock_path)(error).into());
            }
        };
        Ok(Self { path: path.to_owned(), lock, is_guarded, process: process::id() })
    }

    /// Whether a second process is kept out, which needs a file system with locks.
    pub fn is_guarded(&self) -> bool {
        self.is_guarded
    }

    /// Checks that the folder is still where it was, before something is written in it.
    ///
    /// # Errors
    ///
    /// If it was moved, deleted or replaced since it was opened.
    pub fn check(&self) -> Result<(), RunDirError> {
        let lock_path = self.path.join(LOCK_FILE);
        if files::is_at(&lock_path, &self.lock).map_err(FileError::read(&lock_path))? {
            Ok(())
        } else {
            Err(RunDirError::Gone { path: self.path.clone() })
        }
    }

    /// Gives the lock back although forked processes may still have copies of it; does nothing in a
    /// forked process itself.
    pub fn close(self) -> Result<(), FileError> {
        let Self { path, lock, is_guarded, process } = self;
        if process != process::id() || !is_guarded {
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

    /// Writes the settings of the run; the file is complete or not there.
    pub fn write_config(&self, settings: &Settings, run: RunId) -> Result<(), RunDirError> {
        self.check()?;
        let path = self.path.join(CONFIG_FILE);
        files::replace(&path, config_file::text(settings, run)?.as_bytes())?;
        Ok(())
    }
}

/// Whether a lock was refused because the file system, or the network behind it, has none.
fn has_no_locks(error: &io::Error) -> bool {
    #[cfg(unix)]
    let says_so = error.raw_os_error() == Some(rustix::io::Errno::NOLCK.raw_os_error());
    #[cfg(not(unix))]
    let says_so = false;
    says_so || error.kind() == io::ErrorKind::Unsupported
}

/// Whether a process trains in this folder; never, where the file system has no locks.
pub fn is_in_use(path: &Path) -> bool {
    let lock = File::open(path.join(LOCK_FILE)).ok();
    lock.is_some_and(|lock| matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// The first checkpoint is written before the first step, so without one nothing was done. One that
/// is damaged is there.
fn holds_checkpoint(path: &Path) -> Result<bool, FileError> {
    match checkpoint::read_config(path) {
        Err(CheckpointError::Missing { .. }) => Ok(false),
        Err(CheckpointError::File(error)) => Err(error),
        Ok(_) | Err(_) => Ok(true),
    }
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
    /// It is no longer where it was.
    #[error("the run folder `{}` was moved, deleted or replaced during the run", path.display())]
    Gone {
        /// Where it was.
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
