//! Numbers of half the width: how they are rounded, paired and multiplied in plain loops.
//!
//! A bf16 is the upper half of an `f32`. Those here are 0, or between 2⁻⁵⁶ and 2⁶⁴ in magnitude, or
//! no number. So every product of two is exact in an `f32`, and every sum of products is a multiple
//! of 2⁻¹²⁶, the smallest normal number: no result is subnormal. Whether a machine flushes subnormal numbers, and whether it
//! rounds between a multiplication and the addition after it, then makes no difference, and all
//! machines that add in the same order get the same bits.
#![expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]

use super::buffer::{LINE, padded};
use super::product::{PANEL, PairProduct};
use super::simd::Simd;
use pulp::Arch;

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
    fn numbers(self) -> (f32, f32) {
        (f32::from_bits(self.0 << 16), f32::from_bits(self.0 & 0xffff_0000))
    }
}

/// The bits of the nearest bf16, ties to the even one: 0 below [`SMALLEST`], and no number for what
/// is none or [`TOO_LARGE`].
#[inline(always)]
fn round(x: f32) -> u32 {
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

/// Rows of a tile: as many as leave registers for a row of the right matrix.
const TILE_ROWS: usize = 4;

/// The product in plain loops.
pub(super) fn multiply(simd: Simd, product: &mut PairProduct<'_>) {
    let fused = match simd.arch() {
        #[cfg(target_arch = "x86_64")]
        Arch::V3(_) | Arch::V4(_) => true,
        #[cfg(target_arch = "aarch64")]
        Arch::Neon(_) => true,
        _ => false,
    };
    simd.run(
        #[inline(always)]
        || {
            if fused {
                multiply_tiles::<true>(product);
            } else {
                multiply_tiles::<false>(product);
            }
        },
    );
}

/// sum + x · y, which is the same in one step and in two.
#[inline(always)]
fn add_product<const FUSED: bool>(x: f32, y: f32, sum: f32) -> f32 {
    if FUSED { x.mul_add(y, sum) } else { sum + x * y }
}

#[inline(always)]
fn multiply_tiles<const FUSED: bool>(product: &mut PairProduct<'_>) {
    for column in (0..product.columns).step_by(LINE) {
        for row in (0..product.rows).step_by(TILE_ROWS) {
            match product.rows - row {
                1 => multiply_tile::<1, FUSED>(product, row, column),
                2 => multiply_tile::<2, FUSED>(product, row, column),
                3 => multiply_tile::<3, FUSED>(product, row, column),
                _ => multiply_tile::<TILE_ROWS, FUSED>(product, row, column),
            }
        }
    }
}

#[inline(always)]
fn multiply_tile<const ROWS: usize, const FUSED: bool>(
    product: &mut PairProduct<'_>,
    row: usize,
    column: usize,
) {
    let panel = column / PANEL * PANEL;
    let width = padded(product.columns - panel).min(PANEL);
    let right = &product.right[panel * product.depth..][..width * product.depth];
    let mut tile = [[0.0; LINE]; ROWS];
    for (k, right) in right.chunks_exact(width).enumerate() {
        let right = right[column - panel..].first_chunk::<LINE>();
        let right = right.expect("a panel's width is a whole number of lines");
        let right = right.map(Pair::numbers);
        for (index, sums) in tile.iter_mut().enumerate() {
            let (first, second) = product.left.at(row + index, k).numbers();
            for (sum, right) in sums.iter_mut().zip(&right) {
                *sum = add_product::<FUSED>(second, right.1, *sum);
                *sum = add_product::<FUSED>(first, right.0, *sum);
            }
        }
    }
    let written = LINE.min(product.columns - column);
    for (index, sums) in tile.iter().enumerate() {
        let out = &mut product.out[(row + index) * product.out_stride + column..][..written];
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = if product.accumulate { *out + sum } else { *sum };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::gemm_bf16::PairGemm;
    use super::super::product::Left;
    use super::*;
    use rand::{Rng, RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

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
        let smallest = 2.0_f32.powi(-56);
        assert_eq!(round(smallest), SMALLEST);
        for tiny in [0.0, -0.0, 1e-40, -1e-30, smallest * 0.99, f32::MIN_POSITIVE] {
            assert_eq!(round(tiny), 0, "{tiny}");
        }
        let huge = 2.0_f32.powi(64);
        assert!((number(round(huge * 0.99)) / f64::from(huge) - 0.99).abs() < 0.005);
        let nan_of_all_bits = f32::from_bits(u32::MAX);
        for huge in [huge, -huge, huge * 0.9999, f32::INFINITY, f32::NAN, nan_of_all_bits] {
            assert!(number(round(huge)).is_nan(), "{huge}");
        }
    }

    fn draw(count: usize, rng: &mut impl Rng) -> Vec<f32> {
        (0..count)
            .map(|_| {
                let exponent = rng.random_range(-60..30);
                rng.random_range(-2.0..2.0) * 2.0_f32.powi(exponent)
            })
            .collect()
    }

    /// Everything in double precision, where the products are exact.
    fn reference(left: &[f32], right: &[f32], [rows, depth, columns]: [usize; 3]) -> Vec<f64> {
        let bf16 = |x: f32| number(round(x));
        (0..rows * columns)
            .map(|index| {
                let (row, column) = (index / columns, index % columns);
                let products = (0..depth)
                    .map(|k| bf16(left[row * depth + k]) * bf16(right[k * columns + column]));
                products.sum()
            })
            .collect()
    }

    #[test]
    fn every_product_has_the_same_bits_and_is_near_the_exact_one() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let shapes = [[1, 1, 1], [3, 2, 16], [6, 7, 17], [7, 35, 64], [13, 64, 65], [20, 9, 200]];
        for shape @ [rows, depth, columns] in shapes {
            let (left, right) = (draw(rows * depth, &mut rng), draw(depth * columns, &mut rng));
            let before = draw(rows * columns, &mut rng);
            let half = pairs(depth);
            let mut left_pairs = vec![Pair::default(); rows * half];
            pair_columns(&left, depth, depth, &mut left_pairs);
            let mut right_pairs = vec![Pair::default(); half * padded(columns)];
            pair_rows(&right, columns, depth, columns, PANEL, &mut right_pairs);
            let exact = reference(&left, &right, shape);
            for accumulate in [false, true] {
                let computed = |gemm: PairGemm| {
                    let mut out = before.clone();
                    gemm.multiply(PairProduct {
                        left: Left::rows(&left_pairs, half),
                        right: &right_pairs,
                        out: &mut out,
                        out_stride: columns,
                        rows,
                        depth: half,
                        columns,
                        accumulate,
                    });
                    out
                };
                let best = computed(PairGemm::new(Simd::detect()));
                for simd in Simd::every() {
                    let emulated = computed(PairGemm::Emulated(simd));
                    let bits = |out: &[f32]| out.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(&emulated), bits(&best), "{simd:?}, {shape:?}");
                }
                let size = exact.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                for ((found, exact), before) in best.iter().zip(&exact).zip(&before) {
                    let expected = exact + if accumulate { f64::from(*before) } else { 0.0 };
                    let bound = 1e-5 * (size + expected.abs());
                    assert!((f64::from(*found) - expected).abs() <= bound, "{found}, {expected}");
                }
            }
        }
    }

    #[test]
    fn a_transposed_left_matrix_is_paired_along_its_rows() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let [rows, depth] = [5, 7];
        // `[depth, rows]`.
        let transposed = draw(depth * rows, &mut rng);
        let left: Vec<f32> = (0..rows * depth)
            .map(|index| transposed[index % depth * rows + index / depth])
            .collect();
        let half = pairs(depth);
        let stride = padded(rows);
        let mut pairs = vec![Pair::default(); half * stride];
        pair_rows(&transposed, rows, depth, rows, stride, &mut pairs);
        let mut expected = vec![Pair::default(); rows * half];
        pair_columns(&left, depth, depth, &mut expected);
        let found = Left::transposed(&pairs, stride);
        let expected = Left::rows(&expected, half);
        for (row, k) in (0..rows).flat_map(|row| (0..half).map(move |k| (row, k))) {
            assert_eq!(found.at(row, k), expected.at(row, k));
        }
    }
}
