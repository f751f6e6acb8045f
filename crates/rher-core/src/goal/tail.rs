//! What a goal says of an object beside its position: the tail of the object's slot.

use super::metric::Metric;
use super::position::{Position, is_within, unit};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::{array, fmt};

/// Most numbers of an object's tail: an orientation and four more.
pub const TAIL_NUMBERS: usize = 8;

/// Most numbers that networks see of a tail: those of as many angles.
pub(crate) const TAIL_INPUTS: usize = 2 * TAIL_NUMBERS;

/// One part of a tail.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TailPart {
    /// What its numbers mean.
    pub metric: Metric,
    /// How far from what is wanted it may be, in the unit of the metric; of a flag, anything below 1.
    pub tolerance: f32,
}

impl TailPart {
    /// A number that may be so far from the wanted one.
    pub fn difference(tolerance: f32) -> Self {
        Self { metric: Metric::Difference, tolerance }
    }

    /// An angle in radians that may be so far from the wanted one, in radians.
    pub fn angle(tolerance: f32) -> Self {
        Self { metric: Metric::Angle, tolerance }
    }

    /// An orientation, as a quaternion `(x, y, z, w)`, that may be turned so far from the wanted one,
    /// in radians.
    pub fn rotation(tolerance: f32) -> Self {
        Self { metric: Metric::Rotation, tolerance }
    }

    /// A flag, which must say what is wanted.
    pub fn flag() -> Self {
        Self { metric: Metric::Flag, tolerance: 0.5 }
    }
}

/// What the goals of an environment say of every object beside its position, or instead of it.
///
/// ```
/// use rher_core::{TailPart, TailSpec};
///
/// // A block is to be turned by an angle about the vertical axis, and to be lifted.
/// let spec = TailSpec::beside_positions(&[TailPart::angle(0.1), TailPart::flag()])?;
/// assert_eq!(spec.numbers(), 2);
/// let orientations = [TailPart::rotation(0.2); 3];
/// assert_eq!(
///     TailSpec::instead_of_positions(&orientations).unwrap_err().to_string(),
///     "12 numbers for an object, expected at most 8"
/// );
/// # Ok::<(), rher_core::TailError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct TailSpec {
    count: usize,
    parts: [TailPart; TAIL_NUMBERS],
    has_positions: bool,
}

/// A tail cannot be that of a goal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TailError {
    /// It has too many numbers.
    #[error("{numbers} numbers for an object, expected at most {TAIL_NUMBERS}")]
    TooLong {
        /// Its numbers.
        numbers: usize,
    },
    /// There is neither a position nor anything else.
    #[error("goals without positions and without anything else")]
    Nothing,
    /// A tolerance is no distance.
    #[error("part {part} has the tolerance {tolerance}, expected a finite number, at least 0")]
    Tolerance {
        /// Counted from 1.
        part: usize,
        /// What was given.
        tolerance: f32,
    },
    /// A tolerance allows everything.
    #[error("part {part} is a flag with the tolerance {tolerance}, expected less than 1")]
    Flag {
        /// Counted from 1.
        part: usize,
        /// What was given.
        tolerance: f32,
    },
}

/// A [`TailSpec`] in a file.
#[derive(Serialize, Deserialize)]
struct Written {
    parts: Vec<TailPart>,
    has_positions: bool,
}

impl TryFrom<Written> for TailSpec {
    type Error = TailError;

    fn try_from(Written { parts, has_positions }: Written) -> Result<Self, TailError> {
        Self::new(&parts, has_positions)
    }
}

impl From<TailSpec> for Written {
    fn from(spec: TailSpec) -> Self {
        Self { parts: spec.parts().to_vec(), has_positions: spec.has_positions }
    }
}

/// What goals are, such as `positions, angle, flag`.
impl fmt::Display for TailSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let positions = self.has_positions.then_some("positions");
        let parts = self.parts().iter().map(|part| part.metric.name());
        f.write_str(&positions.into_iter().chain(parts).collect::<Vec<_>>().join(", "))
    }
}

impl Default for TailSpec {
    fn default() -> Self {
        Self::NONE
    }
}

impl TailSpec {
    /// Goals are positions and nothing else.
    pub const NONE: Self = Self {
        count: 0,
        parts: [TailPart { metric: Metric::Difference, tolerance: 0.0 }; TAIL_NUMBERS],
        has_positions: true,
    };

    /// Goals that are a position and these parts for every object.
    ///
    /// # Errors
    ///
    /// If there are more than [`TAIL_NUMBERS`] numbers, or if a tolerance is not a distance.
    pub fn beside_positions(parts: &[TailPart]) -> Result<Self, TailError> {
        Self::new(parts, true)
    }

    /// Goals that are these parts for every object, wherever it is. Its position still is what the
    /// gripper has to reach.
    ///
    /// # Errors
    ///
    /// If there are no parts, or more than [`TAIL_NUMBERS`] numbers, or if a tolerance is not a distance.
    pub fn instead_of_positions(parts: &[TailPart]) -> Result<Self, TailError> {
        Self::new(parts, false)
    }

    fn new(given: &[TailPart], has_positions: bool) -> Result<Self, TailError> {
        let numbers = given.iter().map(|part| part.metric.numbers()).sum();
        if numbers > TAIL_NUMBERS {
            return Err(TailError::TooLong { numbers });
        }
        if given.is_empty() && !has_positions {
            return Err(TailError::Nothing);
        }
        for (part, TailPart { metric, tolerance }) in (1..).zip(given.iter().copied()) {
            if !(tolerance.is_finite() && tolerance >= 0.0) {
                return Err(TailError::Tolerance { part, tolerance });
            }
            if metric == Metric::Flag && tolerance >= 1.0 {
                return Err(TailError::Flag { part, tolerance });
            }
        }
        let mut spec = Self { count: given.len(), has_positions, ..Self::NONE };
        spec.parts[..given.len()].copy_from_slice(given);
        Ok(spec)
    }

    /// Whether goals are positions and nothing else.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    /// Its parts.
    #[inline]
    pub fn parts(&self) -> &[TailPart] {
        &self.parts[..self.count]
    }

    /// How many numbers an object has.
    pub fn numbers(&self) -> usize {
        self.parts().iter().map(|part| part.metric.numbers()).sum()
    }

    /// Whether goals have positions, too.
    #[inline]
    pub fn has_positions(&self) -> bool {
        self.has_positions
    }

    /// The same with every tolerance times `share`; flags stay as they are.
    pub(crate) fn scaled(mut self, share: f32) -> Self {
        for part in &mut self.parts[..self.count] {
            if part.metric != Metric::Flag {
                part.tolerance *= share;
            }
        }
        self
    }

    /// Whether goals say the same of an object, whatever the tolerances.
    pub(crate) fn means_the_same(&self, other: &Self) -> bool {
        let metrics = |spec: &Self| spec.parts.map(|part| part.metric);
        self.has_positions == other.has_positions
            && self.count == other.count
            && metrics(self) == metrics(other)
    }

    /// Its parts, and where in a tail the numbers of each are.
    fn places(&self) -> impl Iterator<Item = (TailPart, Range<usize>)> {
        self.parts().iter().scan(0, |start, part| {
            let place = *start..*start + part.metric.numbers();
            *start = place.end;
            Some((*part, place))
        })
    }

    /// Whether an object that should be at `wanted` is there: within `tolerance` meters, and within
    /// the tolerance of every part.
    #[inline]
    pub(crate) fn is_there(
        &self,
        tolerance: f32,
        wanted: (&Position, &Tail),
        reached: (&Position, &Tail),
    ) -> bool {
        (!self.has_positions || is_within(wanted.0, reached.0, tolerance))
            && self.distances(wanted.1, reached.1).all(|(part, far)| far <= part.tolerance)
    }

    /// Its parts, and how far apart two tails are in each.
    fn distances(&self, wanted: &Tail, reached: &Tail) -> impl Iterator<Item = (TailPart, f32)> {
        self.places().map(|(part, place)| {
            (part, part.metric.distance(&wanted[place.clone()], &reached[place]))
        })
    }

    /// How far apart two tails are in each part, in units of its tolerance.
    pub(crate) fn in_tolerances(&self, wanted: &Tail, reached: &Tail) -> impl Iterator<Item = f32> {
        self.distances(wanted, reached).map(|(part, far)| far / unit(part.tolerance))
    }

    /// How many numbers networks see of a tail.
    pub(crate) fn inputs(&self) -> usize {
        self.parts().iter().map(|part| part.metric.inputs().len()).sum()
    }

    /// Names of the numbers that networks see, from one for each part.
    #[cfg(feature = "train")]
    pub(crate) fn input_names(&self, parts: &[String]) -> Vec<String> {
        let of_part = |(part, name): (&TailPart, &String)| {
            part.metric.inputs().iter().map(|input| format!("{name}{input}")).collect::<Vec<_>>()
        };
        self.parts().iter().zip(parts).flat_map(of_part).collect()
    }

    /// Writes what networks see of what is wanted; with `reached`, of the way from there.
    pub(crate) fn encode(&self, wanted: &Tail, reached: Option<&Tail>, mut inputs: &mut [f32]) {
        for (TailPart { metric, .. }, place) in self.places() {
            let (of_part, others) = inputs.split_at_mut(metric.inputs().len());
            match reached {
                None => metric.encode(&wanted[place], of_part),
                Some(reached) => {
                    metric.encode_way(&wanted[place.clone()], &reached[place], of_part);
                }
            }
            inputs = others;
        }
    }
}

/// The numbers of one object's tail, and zeros.
pub(crate) type Tail = [f32; TAIL_NUMBERS];

/// The tails of `N` objects, in relay order: as many numbers for each as the environment's
/// [`TailSpec`] says. The default is zeros, for goals that are positions and nothing else.
///
/// ```
/// use rher_core::Tails;
///
/// // Two blocks, each with an angle and a flag.
/// let tails = Tails::new([[1.5, 0.0], [0.2, 1.0]]);
/// assert_eq!(tails.of_object(1)[..2], [0.2, 1.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tails<const N: usize>([Tail; N]);

impl<const N: usize> Default for Tails<N> {
    fn default() -> Self {
        Self([[0.0; TAIL_NUMBERS]; N])
    }
}

impl<const N: usize> Tails<N> {
    /// Those of objects with `M` numbers each, at most [`TAIL_NUMBERS`].
    pub fn new<const M: usize>(numbers: [[f32; M]; N]) -> Self {
        const { assert!(M <= TAIL_NUMBERS, "a tail has at most 8 numbers") }
        Self(numbers.map(|of_object| array::from_fn(|i| of_object.get(i).copied().unwrap_or(0.0))))
    }

    /// Those of objects with `width` numbers each, one after the other.
    ///
    /// # Panics
    ///
    /// If there are fewer, or if `width` is more than [`TAIL_NUMBERS`].
    pub fn read(numbers: &[f32], width: usize) -> Self {
        let mut tails = Self::default();
        for (object, tail) in tails.0.iter_mut().enumerate() {
            tail[..width].copy_from_slice(&numbers[object * width..(object + 1) * width]);
        }
        tails
    }

    /// The first `width` numbers of each object, one after the other.
    pub fn numbers(&self, width: usize) -> impl Iterator<Item = f32> {
        self.0.into_iter().flat_map(move |tail| tail.into_iter().take(width))
    }

    /// The numbers of an object, followed by zeros.
    ///
    /// # Panics
    ///
    /// If there is no such object.
    #[inline]
    pub fn of_object(&self, object: usize) -> &[f32; TAIL_NUMBERS] {
        &self.0[object]
    }

    /// Those of the objects in another order.
    #[inline]
    pub(crate) fn reordered(&self, order: &[usize; N]) -> Self {
        Self(order.map(|object| self.0[object]))
    }

    /// These for the objects before `end`, and `others` for the rest.
    pub(super) fn before(&self, end: usize, others: &Self) -> Self {
        Self(array::from_fn(|object| if object < end { self.0[object] } else { others.0[object] }))
    }

    /// Those of the objects, each passed through `map`.
    #[must_use]
    pub(crate) fn map(&self, map: impl Fn(&Tail) -> Tail) -> Self {
        Self(array::from_fn(|object| map(&self.0[object])))
    }

    /// The numbers of all objects, each object's followed by zeros: [`TAIL_NUMBERS`] for each.
    pub(crate) fn all(&self) -> &[f32] {
        self.0.as_flattened()
    }
}
