//! The passes over memory that are not matrix products.
//!
//! Plain loops: [`Simd::run`](crate::learner::simd::Simd::run) compiles them for the machine, which needs
//! them inlined there. A matrix is a slice of rows of `stride` numbers, of which the first as many
//! as the other operands have are used.
#![expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]

use super::buffer::LINE;
use crate::learner::engine::{BETA_1, BETA_2, EPSILON};
use crate::learner::network::NORM_EPSILON;
use std::array;

/// x ← x + b.
#[inline(always)]
pub(super) fn add_bias(matrix: &mut [f32], stride: usize, bias: &[f32]) {
    for row in matrix.chunks_exact_mut(stride) {
        for (x, b) in row.iter_mut().zip(bias) {
            *x += b;
        }
    }
}

/// x ← max(x + b, 0).
#[inline(always)]
pub(super) fn add_bias_and_rectify(matrix: &mut [f32], stride: usize, bias: &[f32]) {
    for row in matrix.chunks_exact_mut(stride) {
        for (x, b) in row.iter_mut().zip(bias) {
            *x = rectify(*x + b);
        }
    }
}

/// Not `f32::max`: that would hide a NaN.
#[inline(always)]
fn rectify(x: f32) -> f32 {
    if x < 0.0 { 0.0 } else { x }
}

/// out ← matrix · v.
#[inline(always)]
pub(super) fn multiply_vector(matrix: &[f32], stride: usize, vector: &[f32], out: &mut [f32]) {
    for (row, out) in matrix.chunks(stride).zip(out) {
        *out = dot(&row[..vector.len()], vector);
    }
}

/// sum ← sum + matrixᵀ · v.
#[inline(always)]
pub(super) fn add_weighted_rows(matrix: &[f32], stride: usize, weights: &[f32], sum: &mut [f32]) {
    for (row, w) in matrix.chunks(stride).zip(weights) {
        for (s, x) in sum.iter_mut().zip(row) {
            *s += w * x;
        }
    }
}

/// Each row of `out` ← its factor · v.
#[inline(always)]
pub(super) fn outer(factors: &[f32], vector: &[f32], out: &mut [f32]) {
    for (row, factor) in out.chunks_exact_mut(vector.len()).zip(factors) {
        for (out, x) in row.iter_mut().zip(vector) {
            *out = factor * x;
        }
    }
}

/// δ ← δ where the activation is positive, else 0.
#[inline(always)]
pub(super) fn mask(delta: &mut [f32], activation: &[f32]) {
    for (d, a) in delta.iter_mut().zip(activation) {
        *d = if *a > 0.0 { *d } else { 0.0 };
    }
}

/// [`mask`], its rows added to `sum`.
#[inline(always)]
pub(super) fn mask_and_sum(delta: &mut [f32], activation: &[f32], stride: usize, sum: &mut [f32]) {
    for (delta, activation) in delta.chunks_exact_mut(stride).zip(activation.chunks_exact(stride)) {
        for ((d, a), s) in delta.iter_mut().zip(activation).zip(&mut *sum) {
            *d = if *a > 0.0 { *d } else { 0.0 };
            *s += *d;
        }
    }
}

/// Adds the rows to `sum`.
#[inline(always)]
pub(super) fn sum_rows(matrix: &[f32], stride: usize, sum: &mut [f32]) {
    for row in matrix.chunks_exact(stride) {
        for (s, x) in sum.iter_mut().zip(row) {
            *s += x;
        }
    }
}

/// Scale and shift of a layer normalization, `[width]` each.
pub(super) struct Norm<'a> {
    pub(super) scale: &'a [f32],
    pub(super) shift: &'a [f32],
}

/// n ← (x + b − mean) / deviation in place, and `activation` ← max(n · scale + shift, 0).
#[inline(always)]
pub(super) fn normalize_and_rectify(
    normal: &mut [f32],
    activation: &mut [f32],
    stride: usize,
    inverse_deviation: &mut [f32],
    bias: &[f32],
    norm: &Norm<'_>,
) {
    let width = bias.len();
    let rows = normal.chunks_exact_mut(stride).zip(activation.chunks_exact_mut(stride));
    for ((normal, activation), inverse) in rows.zip(inverse_deviation) {
        let normal = &mut normal[..width];
        let mean = map_and_sum(normal, bias, |x, b| x + b, |x| x) / width as f32;
        let variance = map_and_sum(normal, bias, |x, _| x - mean, |x| x * x) / width as f32;
        *inverse = 1.0 / (variance + NORM_EPSILON).sqrt();
        let affine = norm.scale.iter().zip(norm.shift);
        for ((x, a), (scale, shift)) in normal.iter_mut().zip(activation).zip(affine) {
            *x *= *inverse;
            *a = rectify(*x * scale + shift);
        }
    }
}

/// Takes each of `values` through `map`, and sums what is left of them through `term`, in the order
/// of [`sum`].
#[inline(always)]
fn map_and_sum(
    values: &mut [f32],
    others: &[f32],
    map: impl Fn(f32, f32) -> f32,
    term: impl Fn(f32) -> f32,
) -> f32 {
    let (blocks, rest) = values.as_chunks_mut::<LINE>();
    let (other_blocks, other_rest) = others.as_chunks::<LINE>();
    let mut lanes = [0.0; LINE];
    for (block, others) in blocks.iter_mut().zip(other_blocks) {
        let mapped: [f32; LINE] = array::from_fn(|lane| map(block[lane], others[lane]));
        for lane in 0..LINE {
            lanes[lane] += term(mapped[lane]);
        }
        *block = mapped;
    }
    for ((lane, x), other) in lanes.iter_mut().zip(rest).zip(other_rest) {
        *x = map(*x, *other);
        *lane += term(*x);
    }
    lanes.iter().sum()
}

/// Adds the rows' products, number by number, to `sum`.
#[inline(always)]
pub(super) fn sum_products(left: &[f32], right: &[f32], stride: usize, sum: &mut [f32]) {
    for (left, right) in left.chunks_exact(stride).zip(right.chunks_exact(stride)) {
        for ((s, x), y) in sum.iter_mut().zip(left).zip(right) {
            *s += x * y;
        }
    }
}

/// δ of n · scale + shift ← δ of x, for n = (x − mean) / deviation.
#[inline(always)]
pub(super) fn normalize_backward(
    delta: &mut [f32],
    normal: &[f32],
    stride: usize,
    inverse_deviation: &[f32],
    scale: &[f32],
) {
    let width = scale.len();
    let rows = delta.chunks_exact_mut(stride).zip(normal.chunks_exact(stride));
    for ((delta, normal), inverse) in rows.zip(inverse_deviation) {
        let (delta, normal) = (&mut delta[..width], &normal[..width]);
        for (d, s) in delta.iter_mut().zip(scale) {
            *d *= s;
        }
        let mean = sum(delta, |d| d) / width as f32;
        let slope = dot(delta, normal) / width as f32;
        for (d, n) in delta.iter_mut().zip(normal) {
            *d = (*d - mean - n * slope) * inverse;
        }
    }
}

/// Adam's step sizes for one update.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Learning rate over the first moment's bias correction.
    pub(super) rate: f32,
    /// One over the root of the second moment's bias correction.
    pub(super) inverse_root: f32,
}

/// One Adam step.
#[inline(always)]
pub(super) fn adam(
    step: Step,
    gradient: &[f32],
    online: &mut [f32],
    first_moment: &mut [f32],
    second_moment: &mut [f32],
) {
    let moments = first_moment.iter_mut().zip(second_moment);
    for ((p, g), (m, v)) in online.iter_mut().zip(gradient).zip(moments) {
        *m += (g - *m) * (1.0 - BETA_1);
        *v += (g * g - *v) * (1.0 - BETA_2);
        *p -= step.rate * *m / (v.sqrt() * step.inverse_root + EPSILON);
    }
}

/// θ′ ← θ′ + rate (θ − θ′).
#[inline(always)]
pub(super) fn polyak_update(target: &mut [f32], online: &[f32], rate: f32) {
    for (t, p) in target.iter_mut().zip(online) {
        *t += rate * (p - *t);
    }
}

/// x ← x + y.
#[inline(always)]
pub(super) fn add(sum: &mut [f32], values: &[f32]) {
    for (s, x) in sum.iter_mut().zip(values) {
        *s += x;
    }
}

/// The sum of `values`, each taken through `map`: in an order that no machine changes.
#[inline(always)]
pub(super) fn sum(values: &[f32], map: impl Fn(f32) -> f32) -> f32 {
    let (blocks, rest) = values.as_chunks::<LINE>();
    let mut lanes = [0.0; LINE];
    for block in blocks {
        for (lane, x) in lanes.iter_mut().zip(block) {
            *lane += map(*x);
        }
    }
    for (lane, x) in lanes.iter_mut().zip(rest) {
        *lane += map(*x);
    }
    lanes.iter().sum()
}

#[inline(always)]
fn dot(left: &[f32], right: &[f32]) -> f32 {
    let ((left, left_rest), (right, right_rest)) =
        (left.as_chunks::<LINE>(), right.as_chunks::<LINE>());
    let mut lanes = [0.0; LINE];
    for (x, y) in left.iter().zip(right) {
        for lane in 0..LINE {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    for (lane, (x, y)) in lanes.iter_mut().zip(left_rest.iter().zip(right_rest)) {
        *lane += x * y;
    }
    lanes.iter().sum()
}

/// `to[column][row]` ← `from[row][column]`, for `columns` columns and all rows of `from`.
#[inline(always)]
pub(super) fn transpose(from: &[f32], columns: usize, to: &mut [f32], to_stride: usize) {
    // Four by four in registers, so that the cache lines of `to` are written one after another.
    const SIDE: usize = 4;
    let rows = from.len() / columns;
    let (whole_rows, whole_columns) = (rows / LINE * LINE, columns / SIDE * SIDE);
    for line in (0..whole_rows).step_by(LINE) {
        for column in (0..whole_columns).step_by(SIDE) {
            for row in (line..line + LINE).step_by(SIDE) {
                let block: [[f32; SIDE]; SIDE] = array::from_fn(|index| {
                    let start = (row + index) * columns + column;
                    array::from_fn(|index| from[start..start + SIDE][index])
                });
                for index in 0..SIDE {
                    let start = (column + index) * to_stride + row;
                    to[start..start + SIDE].copy_from_slice(&block.map(|row| row[index]));
                }
            }
        }
    }
    for column in 0..columns {
        let done = if column < whole_columns { whole_rows } else { 0 };
        for row in done..rows {
            to[column * to_stride + row] = from[row * columns + column];
        }
    }
}
