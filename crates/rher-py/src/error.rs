//! From errors of Rust to the exceptions of `rher.errors`.

use pyo3::prelude::*;
use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};

pyo3::import_exception!(rher.errors, EnvError);
pyo3::import_exception!(rher.errors, FileError);
pyo3::import_exception!(rher.errors, InputError);
pyo3::import_exception!(rher.errors, InternalError);
pyo3::import_exception!(rher.errors, PolicyError);
pyo3::import_exception!(rher.errors, SettingsError);
pyo3::import_exception!(rher.errors, StateError);
pyo3::import_exception!(rher.errors, TrainError);

/// An error and its causes, each after a colon.
pub(crate) fn told(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let more = error.to_string();
        if !text.ends_with(&more) {
            text = format!("{text}: {more}");
        }
        cause = error.source();
    }
    text
}

/// Does `work` without Python's lock; a panic in it becomes an exception.
pub(crate) fn unlocked<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        InternalError::new_err(format!("this is a bug in rher: {text}"))
    })
}
