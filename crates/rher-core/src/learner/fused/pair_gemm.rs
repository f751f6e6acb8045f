//! How products of bf16 numbers are computed on this machine.

#[cfg(target_arch = "x86_64")]
use super::dot::Dot;
use super::emulated;
use super::gemm::Gemm;
use super::product::PairProduct;
use super::unpaired;
use crate::learner::simd::Simd;

/// The product by the best means of this machine.
#[derive(Clone, Copy, Debug)]
pub(super) enum PairGemm {
    /// By the instruction for pairs.
    #[cfg(target_arch = "x86_64")]
    Native(Dot),
    /// By the instructions for `f32`.
    Unpaired(Simd, Gemm),
    /// By plain loops.
    Emulated(Simd),
}

impl PairGemm {
    /// By the instruction, if it is there and has passed a test against the plain loops.
    pub(super) fn new(simd: Simd) -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(dot) = Dot::find(simd) {
            return Self::Native(dot);
        }
        Self::without_instruction(simd)
    }

    fn without_instruction(simd: Simd) -> Self {
        match Gemm::new(simd) {
            Gemm::Portable => Self::Emulated(simd),
            gemm @ Gemm::Vectors(_) => Self::Unpaired(simd, gemm),
        }
    }

    /// Writes the product over its `out`, or adds it.
    pub(super) fn multiply(self, mut product: PairProduct<'_>) {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Native(dot) => dot.multiply(product),
            Self::Unpaired(simd, gemm) => unpaired::multiply(simd, gemm, product),
            Self::Emulated(simd) => emulated::multiply(simd, &mut product),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::buffer::padded;
    use super::super::pair::{Pair, pair_columns, pair_rows, pairs, round};
    use super::super::product::{Left, PANEL};
    use super::*;
    use rand::{Rng, RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    fn number(bits: u32) -> f64 {
        f64::from(f32::from_bits(bits << 16))
    }

    fn draw(count: usize, rng: &mut impl Rng) -> Vec<f32> {
        (0..count)
            .map(|_| {
                let exponent = rng.random_range(-60..30);
                rng.random_range(-2.0..2.0) * libm::ldexpf(1.0, exponent)
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
                let best = computed(PairGemm::new(Simd::chosen_or_fastest()));
                let bits = |out: &[f32]| out.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                for simd in Simd::every() {
                    for gemm in [PairGemm::Emulated(simd), PairGemm::without_instruction(simd)] {
                        assert_eq!(bits(&computed(gemm)), bits(&best), "{gemm:?}, {shape:?}");
                    }
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
