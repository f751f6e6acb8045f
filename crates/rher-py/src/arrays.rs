//! Numbers that come from Python and go to it.

use crate::error::InputError;
use numpy::{AllowTypeChange, PyArray1, PyArrayLikeDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

/// Copies `numbers`, anything that NumPy can make an array of, to `out`.
///
/// # Errors
///
/// If it has another shape, something that is not a number, or NaN.
pub(crate) fn read(
    what: &str,
    numbers: &Bound<'_, PyAny>,
    shape: &[usize],
    out: &mut Vec<f32>,
) -> PyResult<()> {
    let array: PyArrayLikeDyn<'_, f32, AllowTypeChange> = numbers.extract().map_err(|error| {
        let py = numbers.py();
        let found = numbers.get_type();
        let wrong = InputError::new_err(format!(
            "{what}: expected an array of numbers of shape {shape:?}, got {found}"
        ));
        wrong.set_cause(py, Some(error));
        wrong
    })?;
    if array.shape() != shape {
        let found = array.shape();
        return Err(InputError::new_err(format!("{what} has shape {found:?}, expected {shape:?}")));
    }
    out.clear();
    match array.as_slice() {
        Ok(slice) => out.extend_from_slice(slice),
        Err(_) => out.extend(array.as_array().iter()),
    }
    match out.iter().position(|x| x.is_nan()) {
        Some(index) => Err(InputError::new_err(format!("number {index} of {what} is NaN"))),
        None => Ok(()),
    }
}

/// A new array of 64-bit numbers, which is what Gymnasium-Robotics' observations are.
pub(crate) fn doubles<'py>(py: Python<'py>, numbers: &[f32]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_iter(py, numbers.iter().map(|x| f64::from(*x)))
}

/// Writes `numbers` as 64-bit numbers; both are equally long.
pub(crate) fn as_doubles(numbers: &[f32], out: &mut [f64]) {
    for (out, number) in out.iter_mut().zip(numbers) {
        *out = f64::from(*number);
    }
}
