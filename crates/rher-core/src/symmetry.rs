//! Symmetries of a scene: mirror images, and objects that may trade names.

use crate::goal::{Position, Tail};
use serde::{Deserialize, Serialize};

/// A plane of symmetry, perpendicular to one world axis: every episode has a mirror image that
/// obeys the same physics.
///
/// ```
/// use rher_core::{Mirror, Position, SignedIndex};
///
/// // A scene that is symmetric about y = 0.75 m, of which x and y are observed.
/// let mirror = Mirror {
///     axis: 1,
///     center: 0.75,
///     observation: vec![
///         SignedIndex { from: 0, sign: 1.0, offset: 0.0 },
///         SignedIndex { from: 1, sign: -1.0, offset: 1.5 },
///     ],
///     action: vec![
///         SignedIndex { from: 0, sign: 1.0, offset: 0.0 },
///         SignedIndex { from: 1, sign: -1.0, offset: 0.0 },
///     ],
///     tail: Vec::new(),
/// };
/// assert_eq!(mirror.position(Position::new(0.3, 0.5, 0.0)), Position::new(0.3, 1.0, 0.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    /// The world axis that is flipped: 0, 1 or 2.
    pub axis: usize,
    /// Where the plane crosses that axis, in meters.
    pub center: f32,
    /// One entry for each number of an observation.
    pub observation: Vec<SignedIndex>,
    /// One entry for each number of an action.
    pub action: Vec<SignedIndex>,
    /// One entry for each number that goals say of an object beside its position; none where they
    /// say nothing.
    pub tail: Vec<SignedIndex>,
}

/// Interchangeable objects in another order: every episode in which they trade names obeys the same
/// physics. Actions stay the same.
///
/// ```
/// use rher_core::{Permutation, SignedIndex};
///
/// // Two blocks trade names; the observation holds the hand's x, then that of each block.
/// let entry = |from| SignedIndex { from, sign: 1.0, offset: 0.0 };
/// let swap = Permutation { order: [1, 0], observation: vec![entry(0), entry(2), entry(1)] };
/// let mut seen = [0.0; 3];
/// SignedIndex::apply(&swap.observation, &[0.1, 0.2, 0.3], &mut seen);
/// assert_eq!(seen, [0.1, 0.3, 0.2]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Permutation<const N: usize> {
    /// For each place in the order, which object comes there.
    pub order: [usize; N],
    /// One entry for each number of an observation.
    pub observation: Vec<SignedIndex>,
}

/// One number of a vector under a symmetry: `sign * original[from] + offset`.
///
/// ```
/// use rher_core::SignedIndex;
///
/// // The mirror image of a coordinate at the plane where it is 0.75 m.
/// let y = SignedIndex { from: 1, sign: -1.0, offset: 1.5 };
/// assert_eq!(y.of(&[0.3, 0.5]), 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignedIndex {
    /// Index in the original vector.
    pub from: usize,
    /// 1 or −1.
    pub sign: f32,
    /// Twice the mirror's place for a coordinate along the flipped axis, 0 for all else.
    pub offset: f32,
}

impl Mirror {
    /// Checks its dimensions and ranges, and that it is its own inverse.
    pub(crate) fn check(
        &self,
        obs_dim: usize,
        action_dim: usize,
        tail: usize,
    ) -> Result<(), Problem> {
        if self.axis > 2 || !self.center.is_finite() {
            let found = format!("axis {} at {} m", self.axis, self.center);
            return Err(Problem::new(found, "axis 0, 1 or 2 at a finite place"));
        }
        for (vector, entries, length) in [
            ("observation", &self.observation, obs_dim),
            ("action", &self.action, action_dim),
            ("tail", &self.tail, tail),
        ] {
            SignedIndex::check(vector, entries, length)?;
            let is_undone = |(index, entry): (usize, &SignedIndex)| {
                let back = entries[entry.from];
                let offset = back.sign * entry.offset + back.offset;
                back.from == index
                    && (back.sign - entry.sign).abs() < f32::EPSILON
                    && offset.abs() <= 1e-5 * (1.0 + entry.offset.abs())
            };
            if let Some(index) = (0..length).find(|index| !is_undone((*index, &entries[*index]))) {
                let found = format!("{vector}[{index}], which its own image does not restore");
                return Err(Problem::new(found, "a mirror that is its own inverse"));
            }
        }
        Ok(())
    }

    /// The mirror image of a point.
    #[must_use]
    #[inline]
    pub fn position(&self, position: Position) -> Position {
        let mut mirrored = position;
        mirrored[self.axis] = 2.0 * self.center - position[self.axis];
        mirrored
    }
}

impl<const N: usize> Permutation<N> {
    /// Checks its dimensions and ranges, and that every object and every number is used once.
    pub(crate) fn check(&self, obs_dim: usize) -> Result<(), Problem> {
        let mut sorted = self.order;
        sorted.sort_unstable();
        if sorted.iter().enumerate().any(|(place, object)| place != *object) {
            let found = format!("the order {:?}", self.order);
            return Err(Problem::new(found, format!("each of the objects 0 to {} once", N - 1)));
        }
        SignedIndex::check("observation", &self.observation, obs_dim)?;
        let mut used = vec![false; obs_dim];
        for (index, entry) in self.observation.iter().enumerate() {
            if std::mem::replace(&mut used[entry.from], true) {
                let found =
                    format!("observation[{index}], whose number {} is used twice", entry.from);
                return Err(Problem::new(found, "each number of an observation once"));
            }
        }
        Ok(())
    }
}

/// What is wrong with a symmetry.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) found: String,
    pub(crate) expected: String,
}

impl Problem {
    fn new(found: String, expected: impl Into<String>) -> Self {
        Self { found, expected: expected.into() }
    }
}

impl SignedIndex {
    fn check(vector: &str, entries: &[Self], length: usize) -> Result<(), Problem> {
        if entries.len() != length {
            let found = format!("{} entries for its {vector}", entries.len());
            return Err(Problem::new(found, length.to_string()));
        }
        let fits = |entry: &Self| {
            entry.from < length && matches!(entry.sign, 1.0 | -1.0) && entry.offset.is_finite()
        };
        match entries.iter().position(|entry| !fits(entry)) {
            Some(index) => {
                let Self { from, sign, offset } = entries[index];
                let found = format!("{sign} × number {from} + {offset} in {vector}[{index}]");
                let expected = format!("±1 × a number below {length} + a finite offset");
                Err(Problem::new(found, expected))
            }
            None => Ok(()),
        }
    }

    /// The images of a vector of so many numbers that nothing changes.
    pub(crate) fn none(length: usize) -> Vec<Self> {
        (0..length).map(|from| Self { from, sign: 1.0, offset: 0.0 }).collect()
    }

    /// The images under one symmetry and then another; no entries are no change.
    pub(crate) fn then(first: &[Self], second: &[Self]) -> Vec<Self> {
        let both = |second: &Self| match first.get(second.from) {
            None => *second,
            Some(Self { from, sign, offset }) => Self {
                from: *from,
                sign: second.sign * sign,
                offset: second.sign * offset + second.offset,
            },
        };
        second.iter().map(both).collect()
    }

    /// This number of the image of `original`.
    #[inline]
    pub fn of(&self, original: &[f32]) -> f32 {
        self.sign * original[self.from] + self.offset
    }

    /// The image of the first numbers of a tail, as many as there are `images`.
    pub(crate) fn image(images: &[Self], tail: &Tail) -> Tail {
        let mut image = *tail;
        let width = images.len();
        Self::apply(images, &tail[..width], &mut image[..width]);
        image
    }

    /// Writes the image of `original` to `image`; all three are equally long.
    #[inline]
    pub fn apply(images: &[Self], original: &[f32], image: &mut [f32]) {
        debug_assert!(images.len() == original.len() && original.len() == image.len());
        for (out, number) in image.iter_mut().zip(images) {
            *out = number.of(original);
        }
    }
}
