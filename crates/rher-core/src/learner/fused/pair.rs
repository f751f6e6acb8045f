//! Numbers of half the width: how they are rounded and paired for products.
//!
//! A bf16 is the upper half of an `f32`. Those here are 0, or between 2⁻⁵⁶ and 2⁶⁴ in magnitude, or
//! no number. So every product of two is exact in an `f32`, and every sum of products is a multiple
//! of 2⁻¹²⁶, the smallest normal number: no result is subnormal. Whether a machine flushes subnormal numbers, and whether it
//! rounds between a multiplication and the addition after it, then makes no difference, and all
//! machines that add in the same order get the same bits.
#![expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]

use super::buffer::padded;

/// Two numbers that a product takes in one step: the bits of the second above those of the first.
///
/// The second is multiplied and added before the first, as `VDPBF16PS` does it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Pair(u32);

/// Bits of the smallest magnitude but 0, 2⁻⁵⁶, and of the first that is too large, 2⁶⁴.
const SMALLEST: u32 = (127 - 56) << 7;
const TOO_LARGE: u32 = (127 + 64) << 7;
const NOT_A_NUMBER: u32 = 0x7fc0;

impl Pair {
    #[inline(always)]
    pub(super) fn new(first: f32, second: f32) -> Self {
        Self(round(first) | round(second) << 16)
    }

    /// The two numbers.
    #[inline(always)]
    pub(super) fn numbers(self) -> (f32, f32) {
        (f32::from_bits(self.0 << 16), f32::from_bits(self.0 & 0xffff_0000))
    }
}

/// The bits of the nearest bf16, ties to the even one: 0 below [`SMALLEST`], and no number for what
/// is none or [`TOO_LARGE`].
#[inline(always)]
pub(super) fn round(x: f32) -> u32 {
    let bits = x.to_bits();
    let magnitude = bits & 0x7fff_ffff;
    let rounded = (magnitude + 0x7fff + (magnitude >> 16 & 1)) >> 16;
    let number = if rounded < TOO_LARGE { rounded } else { NOT_A_NUMBER };
    if rounded < SMALLEST { 0 } else { number | bits >> 16 & 0x8000 }
}

/// Pairs along a dimension of this length; the last one's second number may be 0.
pub(super) fn pairs(length: usize) -> usize {
    length.div_ceil(2)
}

/// Numbers of every row in pairs, the j-th with the j-th of the row's second half: `[rows, pairs]`
/// from `[rows, width]`, a row every `stride` numbers.
#[inline(always)]
pub(super) fn pair_columns(matrix: &[f32], stride: usize, width: usize, out: &mut [Pair]) {
    let pairs = pairs(width);
    for (row, out) in matrix.chunks(stride).zip(out.chunks_exact_mut(pairs)) {
        let (first, second) = row[..width].split_at(pairs);
        for ((out, x), y) in out.iter_mut().zip(first).zip(second) {
            *out = Pair::new(*x, *y);
        }
        if second.len() < pairs {
            out[pairs - 1] = Pair::new(first[pairs - 1], 0.0);
        }
    }
}

/// Rows in pairs, the j-th with the j-th of the matrix's second half: `[pairs, columns]` from
/// `[rows, columns]`, a row every `stride` numbers.
///
/// Cut in panels of `panel` columns, each `[pairs, width]` with a width of whole vectors.
#[inline(always)]
pub(super) fn pair_rows(
    matrix: &[f32],
    stride: usize,
    rows: usize,
    columns: usize,
    panel: usize,
    out: &mut [Pair],
) {
    let pairs = pairs(rows);
    for start in (0..columns).step_by(panel) {
        let width = panel.min(columns - start);
        let out = out[start * pairs..].chunks_mut(padded(width));
        for (index, out) in (0..pairs).zip(out) {
            let first = &matrix[index * stride + start..][..width];
            match index + pairs {
                other if other < rows => {
                    let second = &matrix[other * stride + start..][..width];
                    for ((out, x), y) in out.iter_mut().zip(first).zip(second) {
                        *out = Pair::new(*x, *y);
                    }
                }
                _ => {
                    for (out, x) in out.iter_mut().zip(first) {
                        *out = Pair::new(*x, 0.0);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(bits: u32) -> f64 {
        f64::from(f32::from_bits(bits << 16))
    }

    #[test]
    fn rounding_is_to_the_nearest_and_ties_are_even() {
        for bits in SMALLEST..TOO_LARGE - 1 {
            let (x, next) = (bits << 16, (bits + 1) << 16);
            let middle = x + (1 << 15);
            for sign in [0, 1 << 31] {
                let rounded = |bits: u32| round(f32::from_bits(bits | sign));
                let sign = sign >> 16;
                assert_eq!(rounded(x), bits | sign);
                assert_eq!(rounded(middle - 1), bits | sign);
                assert_eq!(rounded(middle + 1), (bits + 1) | sign);
                assert_eq!(rounded(middle), (bits + bits % 2) | sign);
                assert_eq!(rounded(next - 1), (bits + 1) | sign);
            }
        }
    }

    #[test]
    fn what_is_tiny_becomes_0_and_what_is_huge_no_number() {
        let smallest = libm::ldexpf(1.0, -56);
        assert_eq!(round(smallest), SMALLEST);
        for tiny in [0.0, -0.0, 1e-40, -1e-30, smallest * 0.99, f32::MIN_POSITIVE] {
            assert_eq!(round(tiny), 0, "{tiny}");
        }
        let huge = libm::ldexpf(1.0, 64);
        assert!((number(round(huge * 0.99)) / f64::from(huge) - 0.99).abs() < 0.005);
        let nan_of_all_bits = f32::from_bits(u32::MAX);
        for huge in [huge, -huge, huge * 0.9999, f32::INFINITY, f32::NAN, nan_of_all_bits] {
            assert!(number(round(huge)).is_nan(), "{huge}");
        }
    }
}
