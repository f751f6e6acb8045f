//! The symmetries of an environment that someone else wrote.

use crate::error::InputError;
use pyo3::PyResult;
use rher_core::env::{Mirror, Permutation, SignedIndex};
use serde::{Deserialize, Serialize};

/// What Python says of symmetries.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Symmetries {
    mirrors: Vec<OfMirror>,
    permutations: Vec<OfPermutation>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OfMirror {
    axis: usize,
    center: f32,
    observation: Vec<SignedIndex>,
    action: Vec<SignedIndex>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OfPermutation {
    order: Vec<usize>,
    observation: Vec<SignedIndex>,
}

impl Symmetries {
    pub(crate) fn is_none(&self) -> bool {
        self.mirrors.is_empty() && self.permutations.is_empty()
    }

    pub(crate) fn mirrors(&self) -> Vec<Mirror> {
        let mirror = |OfMirror { axis, center, observation, action }: &OfMirror| Mirror {
            axis: *axis,
            center: *center,
            observation: observation.clone(),
            action: action.clone(),
            tail: Vec::new(),
        };
        self.mirrors.iter().map(mirror).collect()
    }

    /// Those of a scene with `N` objects.
    ///
    /// # Errors
    ///
    /// [`InputError`] if one is of another number of objects.
    pub(crate) fn permutations<const N: usize>(&self) -> PyResult<Vec<Permutation<N>>> {
        let permutation = |OfPermutation { order, observation }: &OfPermutation| {
            let order = order.as_slice().try_into().map_err(|_| {
                InputError::new_err(format!("a permutation is of {order:?}, expected {N} objects"))
            })?;
            Ok(Permutation { order, observation: observation.clone() })
        };
        self.permutations.iter().map(permutation).collect()
    }
}
