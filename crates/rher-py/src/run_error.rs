//! From errors of runs to exceptions.

use crate::error::{EnvError, FileError, InputError, PolicyError, SettingsError, TrainError, told};
use pyo3::prelude::*;
use rher_core::files::FileError as CoreFileError;
use rher_core::policy::PolicyError as CorePolicyError;
use rher_core::train::checkpoint::CheckpointError;
use rher_core::train::{PretrainedError, TrainError as CoreTrainError};
use rher_runs::{RunDirError, RunFilesError, SettingsError as CoreSettingsError};

pub(crate) fn from_settings(error: CoreSettingsError) -> PyErr {
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

pub(crate) fn from_run_dir(error: RunDirError) -> PyErr {
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

pub(crate) fn from_files(error: RunFilesError) -> PyErr {
    match error {
        RunFilesError::Folder(error) => from_run_dir(error),
        error => FileError::new_err(told(&error)),
    }
}

pub(crate) fn from_write(error: &CoreFileError) -> PyErr {
    FileError::new_err(told(error))
}

pub(crate) fn from_checkpoint(error: &CheckpointError) -> PyErr {
    match error {
        CheckpointError::Policy(CorePolicyError::Malformed { .. }) => {
            PolicyError::new_err(told(error))
        }
        CheckpointError::Mismatch { .. } => InputError::new_err(told(error)),
        _ => FileError::new_err(told(error)),
    }
}

/// What stopped a run; `raised` is what the user's environment raised.
pub(crate) fn from_train(error: &CoreTrainError, raised: Option<PyErr>) -> PyErr {
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
