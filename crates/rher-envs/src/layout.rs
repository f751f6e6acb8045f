//! How an episode begins, and what may be chosen of it.

use nalgebra::Point3;
use rher_core::goal::Position;
use serde::{Deserialize, Serialize};
use std::array;

/// How far an object may be from where it was asked to start, in meters: larger than usual, it is
/// put higher by half of what it is larger by.
const NEAR: f32 = 0.02;

/// Where an episode begins and what it asks for; positions are centers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout<const N: usize> {
    /// Where each object starts.
    pub objects: [Position; N],
    /// How far each object is turned about the vertical, in radians.
    pub turns: [f32; N],
    /// Where each object should go.
    pub targets: [Position; N],
}

impl<const N: usize> Layout<N> {
    /// Objects that are not turned.
    #[must_use]
    pub fn new(objects: [Position; N], targets: [Position; N]) -> Self {
        Self { objects, turns: [0.0; N], targets }
    }
}

/// What is chosen of a [`Layout`]; the rest is drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chosen {
    /// `[3 N]`: where each object starts, in meters.
    pub objects: Option<Vec<f32>>,
    /// `[N]`: how far each object is turned about the vertical, in radians.
    pub turns: Option<Vec<f32>>,
    /// `[3 N]`: where each object should go, in meters.
    pub targets: Option<Vec<f32>>,
}

/// An episode cannot begin as it was chosen.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChosenError {
    /// There are too many or too few numbers.
    #[error("{what}: {got} numbers, expected {expected}")]
    Width {
        /// Which part.
        what: &'static str,
        /// Numbers that it needs.
        expected: usize,
        /// Numbers that came.
        got: usize,
    },
    /// A number is NaN or infinite.
    #[error("number {index} of the {what} is {value}")]
    NotFinite {
        /// Which part.
        what: &'static str,
        /// Place in it.
        index: usize,
        /// What it is.
        value: f32,
    },
    /// The task puts an object elsewhere.
    #[error(
        "object {} cannot start at {asked:?}: this task puts it at {found:?}",
        object + 1
    )]
    Elsewhere {
        /// Which object, from 0.
        object: usize,
        /// Where it was asked to be, in meters.
        asked: [f32; 3],
        /// Where it is, in meters.
        found: [f32; 3],
    },
}

impl Chosen {
    /// `drawn` with what is chosen in its place.
    pub(crate) fn of<const N: usize>(&self, drawn: Layout<N>) -> Result<Layout<N>, ChosenError> {
        let Self { objects, turns, targets } = self;
        let places = |what, chosen: &Option<Vec<f32>>, drawn: [Position; N]| match chosen {
            Some(numbers) => {
                check(what, numbers, 3 * N)?;
                Ok(array::from_fn(|i| Point3::from_slice(&numbers[3 * i..3 * i + 3])))
            }
            None => Ok(drawn),
        };
        let turns = match turns {
            Some(numbers) => {
                check("turns", numbers, N)?;
                array::from_fn(|i| numbers[i])
            }
            None => drawn.turns,
        };
        Ok(Layout {
            objects: places("places of objects", objects, drawn.objects)?,
            turns,
            targets: places("targets", targets, drawn.targets)?,
        })
    }

    /// Whether the objects are where they were asked to start.
    pub(crate) fn check(&self, found: &[Position]) -> Result<(), ChosenError> {
        let asked = self.objects.iter().flat_map(|numbers| numbers.chunks_exact(3));
        for (object, (asked, found)) in asked.zip(found).enumerate() {
            if nalgebra::distance(&Point3::from_slice(asked), found) > NEAR {
                return Err(ChosenError::Elsewhere {
                    object,
                    asked: [asked[0], asked[1], asked[2]],
                    found: [found.x, found.y, found.z],
                });
            }
        }
        Ok(())
    }
}

fn check(what: &'static str, numbers: &[f32], expected: usize) -> Result<(), ChosenError> {
    if numbers.len() != expected {
        return Err(ChosenError::Width { what, expected, got: numbers.len() });
    }
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(index) => Err(ChosenError::NotFinite { what, index, value: numbers[index] }),
        None => Ok(()),
    }
}
