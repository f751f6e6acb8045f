//! Calls of environments in Python: what they raise is kept, and after Ctrl-C there are no more.

use pyo3::prelude::*;
use rher_core::env::EnvError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What the environments of a run and the run itself share.
#[derive(Clone, Default)]
pub(crate) struct Calls {
    /// The exception that an environment raised, which errors of the core cannot carry.
    raised: Arc<Mutex<Option<PyErr>>>,
    /// Whether Ctrl-C was pressed, or something else raised that stops the run at once.
    interrupted: Arc<AtomicBool>,
}

/// An environment did not do what was expected.
#[derive(Debug, thiserror::Error)]
enum CallError {
    #[error("it raised {0}")]
    Raised(String),
    #[error("it was not called, because the run was interrupted")]
    Interrupted,
}

impl Calls {
    /// Calls Python, unless the run was interrupted: the environment may be a robot.
    pub(crate) fn call<T>(
        &self,
        work: impl FnOnce(Python<'_>) -> PyResult<T>,
    ) -> Result<T, EnvError> {
        if self.is_interrupted() {
            return Err(EnvError::new(CallError::Interrupted));
        }
        Python::attach(|py| {
            work(py).map_err(|error| {
                let text = error.to_string();
                *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                EnvError::new(CallError::Raised(text))
            })
        })
    }

    /// Takes the exception that an environment raised.
    pub(crate) fn take_raised(&self) -> Option<PyErr> {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// From here on there are no calls.
    pub(crate) fn interrupt(&self) {
        self.interrupted.store(true, Ordering::Relaxed);
    }

    /// From here on there are calls again.
    pub(crate) fn allow(&self) {
        self.interrupted.store(false, Ordering::Relaxed);
    }

    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}
