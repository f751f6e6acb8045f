//! How far apart numbers of a goal are that are no position, and how networks see them.

use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};
use std::f32::consts::TAU;

/// What numbers beside a position mean: how far apart two of them are.
///
/// ```
/// use rher_core::Metric;
///
/// let close = |found: f32, expected: f32| (found - expected).abs() < 1e-6;
/// assert!(close(Metric::Difference.distance(&[0.3], &[0.1]), 0.2));
/// assert!(close(Metric::Angle.distance(&[3.1], &[3.1 - std::f32::consts::TAU]), 0.0));
/// assert_eq!(Metric::Rotation.distance(&[0.0, 0.0, 0.0, 1.0], &[0.0, 0.0, 0.0, -1.0]), 0.0);
/// assert_eq!(Metric::Flag.distance(&[1.0], &[0.0]), 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    /// One number, such as the opening of a gripper in meters: the absolute difference.
    Difference,
    /// One angle in radians: the smaller of the two turns from one to the other, at most π.
    Angle,
    /// An orientation, as a quaternion `(x, y, z, w)` of any length but 0: the angle in radians by
    /// which one has to be turned to be the other, at most π. `q` and `−q` are the same orientation.
    Rotation,
    /// One number that says yes (above 0.5) or no: 0 where both say the same, and 1 elsewhere.
    Flag,
}

impl Metric {
    /// How many numbers of a goal it compares.
    pub const fn numbers(self) -> usize {
        match self {
            Self::Difference | Self::Angle | Self::Flag => 1,
            Self::Rotation => 4,
        }
    }

    /// Its name in messages.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Difference => "difference",
            Self::Angle => "angle",
            Self::Rotation => "rotation",
            Self::Flag => "flag",
        }
    }

    /// How far apart two values are; each has [`numbers`](Self::numbers) numbers.
    ///
    /// # Panics
    ///
    /// If they have fewer.
    pub fn distance(self, one: &[f32], other: &[f32]) -> f32 {
        match self {
            Self::Difference => (one[0] - other[0]).abs(),
            Self::Angle => {
                let turn = (one[0] - other[0]).abs() % TAU;
                turn.min(TAU - turn)
            }
            Self::Rotation => {
                let turn = quaternion(one) * quaternion(other).conjugate();
                2.0 * libm::atan2f(turn.imag().norm(), turn.w.abs())
            }
            Self::Flag => (flag(one[0]) - flag(other[0])).abs(),
        }
    }

    /// Names of the numbers that networks see of a value, after the name of the value itself.
    pub(super) const fn inputs(self) -> &'static [&'static str] {
        match self {
            Self::Difference | Self::Flag => &[""],
            Self::Angle => &[".cos", ".sin"],
            Self::Rotation => &[".xx", ".xy", ".xz", ".yx", ".yy", ".yz"],
        }
    }

    /// Writes what networks see of `value`, which is continuous where the metric is: cosine and sine
    /// of an angle, the first two axes of an orientation.
    pub(super) fn encode(self, value: &[f32], inputs: &mut [f32]) {
        match self {
            Self::Difference => inputs[0] = value[0],
            Self::Angle => turned(value[0], inputs),
            Self::Rotation => axes(quaternion(value), inputs),
            Self::Flag => inputs[0] = flag(value[0]),
        }
    }

    /// Writes what networks see of the way from `reached` to `wanted`.
    pub(super) fn encode_way(self, wanted: &[f32], reached: &[f32], inputs: &mut [f32]) {
        match self {
            Self::Difference => inputs[0] = wanted[0] - reached[0],
            Self::Angle => turned(wanted[0] - reached[0], inputs),
            Self::Rotation => axes(quaternion(wanted) * quaternion(reached).conjugate(), inputs),
            Self::Flag => inputs[0] = flag(wanted[0]) - flag(reached[0]),
        }
    }
}

fn flag(number: f32) -> f32 {
    f32::from(u8::from(number > 0.5))
}

fn quaternion(numbers: &[f32]) -> Quaternion<f32> {
    Quaternion::new(numbers[3], numbers[0], numbers[1], numbers[2])
}

fn turned(angle: f32, inputs: &mut [f32]) {
    inputs[..2].copy_from_slice(&[libm::cosf(angle), libm::sinf(angle)]);
}

fn axes(turn: Quaternion<f32>, inputs: &mut [f32]) {
    let turn = UnitQuaternion::try_new(turn, f32::MIN_POSITIVE).unwrap_or_default();
    let matrix = turn.to_rotation_matrix();
    inputs[..6].copy_from_slice(&matrix.matrix().as_slice()[..6]);
}
