//! The half of the Python package `rher` that is written in Rust.
//!
//! Nothing here holds Python's lock while it simulates or learns, and every error is one of
//! `rher.errors`.

#![expect(clippy::needless_pass_by_value, reason = "Python hands arguments over by value")]

mod any_env;
mod any_pool;
mod any_recorder;
mod any_trainer;
mod arrays;
mod calls;
mod command;
mod env;
mod error;
mod foreign;
mod goals;
mod hindsight;
mod limits;
mod made;
mod onnx;
mod picture;
mod places;
mod policy;
mod run_error;
mod state;
mod symmetries;
mod threads;
mod train;
mod vector;
mod watch;

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;
use rher_core::learner::simd::Simd;

/// Compiled half of `rher`; use the package itself.
#[pymodule]
mod _rher {
    #[pymodule_export]
    use super::command::main;
    #[pymodule_export]
    use super::env::Env;
    #[pymodule_export]
    use super::hindsight::Hindsight;
    #[pymodule_export]
    use super::made::{subtasks, tasks};
    #[pymodule_export]
    use super::onnx::export_onnx;
    #[pymodule_export]
    use super::policy::Policy;
    #[pymodule_export]
    use super::state::State;
    #[pymodule_export]
    use super::train::{Trainer, run_settings, run_state};
    #[pymodule_export]
    use super::vector::VectorEnv;
    use super::{Bound, PyImportError, PyModule, PyResult, Simd};

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "its name in Python")]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        Simd::chosen().map(drop).map_err(|error| PyImportError::new_err(error.to_string()))
    }
}
