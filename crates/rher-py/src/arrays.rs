//! Arrays that come from Python and go to it.
//!
//! Everything that takes an array reads it here, so that its numbers come in the order of its
//! indices: rust-numpy's slices are in the order of memory, which is another one for a transposed
//! array.

use crate::error::InputError;
use numpy::{
    Element, PyArray1, PyArrayDyn, PyArrayMethods as _, PyReadonlyArrayDyn,
    PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use std::fmt::Arguments;

/// Replaces the contents of `out` by `array`, which may be anything that NumPy can make an array
/// of, of exactly this shape. Infinite numbers are allowed.
///
/// # Errors
///
/// [`InputError`] if it has another shape, holds something that is not a number, or NaN.
pub(crate) fn read(
    what: &str,
    array: &Bound<'_, PyAny>,
    shape: &[usize],
    out: &mut Vec<f32>,
) -> PyResult<()> {
    read_as_is(what, array, shape, out)?;
    refuse(what, out, |x| x.is_nan())
}

/// As [`read`], with NaN allowed.
pub(crate) fn read_as_is(
    what: &str,
    array: &Bound<'_, PyAny>,
    shape: &[usize],
    out: &mut Vec<f32>,
) -> PyResult<()> {
    let rows = RowMajor::of(what, array, format_args!("{shape:?}"))?;
    let found = rows.shape();
    if found != shape {
        return Err(InputError::new_err(format!("{what} has shape {found:?}, expected {shape:?}")));
    }
    rows.copy_to(out);
    Ok(())
}

/// Rows of numbers, and how they are arranged.
pub(crate) struct Rows {
    /// Every axis but the last: `[]` for one row, `[batch]` for a batch.
    pub(crate) batch: Vec<usize>,
    /// `[..., width]`.
    pub(crate) numbers: Vec<f32>,
}

impl Rows {
    /// Reads an array of shape `[..., width]`.
    ///
    /// # Errors
    ///
    /// [`InputError`] if its rows have another width, which ends in `hint`, or if it holds something
    /// that is not a number.
    pub(crate) fn read(
        what: &str,
        array: &Bound<'_, PyAny>,
        width: usize,
        hint: &str,
    ) -> PyResult<Self> {
        let rows = RowMajor::of(what, array, format_args!("(..., {width})"))?;
        let batch = match rows.shape() {
            [batch @ .., last] if *last == width => batch.to_vec(),
            shape => {
                return Err(InputError::new_err(format!(
                    "{what} has shape {shape:?}, expected ({width},) or (batch, {width}){hint}"
                )));
            }
        };
        let mut numbers = Vec::new();
        rows.copy_to(&mut numbers);
        Ok(Self { batch, numbers })
    }

    /// The same rows.
    ///
    /// # Errors
    ///
    /// [`InputError`] if a number is infinite or NaN.
    pub(crate) fn finite(self, what: &str) -> PyResult<Self> {
        refuse(what, &self.numbers, |x| !x.is_finite())?;
        Ok(self)
    }
}

fn refuse(what: &str, numbers: &[f32], is_wrong: impl Fn(&f32) -> bool) -> PyResult<()> {
    match numbers.iter().position(is_wrong) {
        Some(index) => {
            let number = numbers[index];
            Err(InputError::new_err(format!("number {index} of {what} is {number}")))
        }
        None => Ok(()),
    }
}

/// An array whose order in memory is the order of its indices, the last one changing fastest.
enum RowMajor<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>),
    Double(PyReadonlyArrayDyn<'py, f64>),
}

impl<'py> RowMajor<'py> {
    /// `array` itself if it is one, or else a copy that NumPy makes.
    fn of(what: &str, array: &Bound<'py, PyAny>, expected: Arguments<'_>) -> PyResult<Self> {
        static CONVERT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        if let Some(array) = Self::cast(array) {
            return Ok(array);
        }
        let py = array.py();
        let converted = CONVERT
            .import(py, "rher._arrays", "as_numbers")
            .and_then(|convert| convert.call1((array,)))
            .map_err(|error| {
                let found = array.get_type();
                let wrong = InputError::new_err(format!(
                    "{what}: expected an array of numbers of shape {expected}, got {found}"
                ));
                wrong.set_cause(py, Some(error));
                wrong
            })?;
        Self::cast(&converted).ok_or_else(|| {
            InputError::new_err(format!("{what}: NumPy cannot copy {} to memory", array.get_type()))
        })
    }

    fn cast(array: &Bound<'py, PyAny>) -> Option<Self> {
        ordered(array).map(Self::Single).or_else(|| ordered(array).map(Self::Double))
    }

    fn shape(&self) -> &[usize] {
        match self {
            Self::Single(array) => array.shape(),
            Self::Double(array) => array.shape(),
        }
    }

    fn copy_to(&self, out: &mut Vec<f32>) {
        out.clear();
        match self {
            Self::Single(array) => out.extend_from_slice(slice(array)),
            Self::Double(array) => out.extend(slice(array).iter().map(|x| *x as f32)),
        }
    }
}

/// `array`, if its numbers are of this type, aligned, and in the order of its indices.
fn ordered<'py, T: Element>(array: &Bound<'py, PyAny>) -> Option<PyReadonlyArrayDyn<'py, T>> {
    let array = array.cast::<PyArrayDyn<T>>().ok()?.try_readonly().ok()?;
    (array.is_c_contiguous() && array.as_slice().is_ok()).then_some(array)
}

fn slice<'a, T: Element>(array: &'a PyReadonlyArrayDyn<'_, T>) -> &'a [T] {
    array.as_slice().expect("only contiguous arrays are kept")
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
