//! Policies as ONNX models, for Python.

use crate::error::{FileError, InputError, PolicyError, told, unlocked};
use crate::policy::Policy;
use pyo3::prelude::*;
use rher_core::{OnnxError, OnnxModel, PolicyError as CorePolicyError};
use std::path::PathBuf;

/// What is exported.
#[derive(FromPyObject)]
pub(crate) enum Exported<'py> {
    Policy(Bound<'py, Policy>),
    File(PathBuf),
}

/// Writes a policy as an ONNX model, and beside it what its numbers are.
#[pyfunction]
pub(crate) fn export_onnx(py: Python<'_>, policy: Exported<'_>, out: PathBuf) -> PyResult<()> {
    let model = match policy {
        Exported::Policy(policy) => {
            let policy = policy.get();
            unlocked(py, || OnnxModel::of_policy(policy.frozen()))
        }
        Exported::File(path) => unlocked(py, || OnnxModel::of_file(&path)),
    };
    let model = model?.map_err(from_onnx)?;
    unlocked(py, || model.save(&out))?.map_err(from_onnx)?;
    Ok(())
}

fn from_onnx(error: OnnxError) -> PyErr {
    match error {
        OnnxError::File(_) | OnnxError::Policy(CorePolicyError::File(_)) => {
            FileError::new_err(told(&error))
        }
        OnnxError::Name { .. } => InputError::new_err(told(&error)),
        _ => PolicyError::new_err(told(&error)),
    }
}
