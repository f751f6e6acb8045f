//! Fused multiply-add for machines without the instruction: the same bits, without the C library.

/// a · b + c, rounded once.
///
/// The product of two `f32` is exact in an `f64`. Their sum with `c` is rounded to odd there: that
/// keeps enough of what is lost to round correctly to an `f32`, also to one that is subnormal
/// (Boldo and Melquiond, "Emulation of FMA and correctly rounded sums: proved algorithms using
/// rounding to odd", 2008).
#[expect(clippy::inline_always, reason = "called for every product of a matrix product")]
#[inline(always)]
pub(super) fn multiply_add(a: f32, b: f32, c: f32) -> f32 {
    let (product, c) = (f64::from(a) * f64::from(b), f64::from(c));
    let sum = product + c;
    let of_c = sum - product;
    let lost = (product - (sum - of_c)) + (c - of_c);
    // False where the sum is infinite or NaN, whose `lost` is NaN.
    let inexact = u64::from(lost > 0.0) | u64::from(lost < 0.0);
    let rounded_up = inexact & ((lost.to_bits() ^ sum.to_bits()) >> 63);
    f64::from_bits((sum.to_bits() - rounded_up) | inexact) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learner::simd::Simd;
    use proptest::prelude::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    /// The instruction, where the machine has it.
    #[expect(clippy::disallowed_methods, reason = "it is what is expected")]
    fn assert_fused(numbers: &[[f32; 3]]) {
        Simd::every()[0].run(
            #[inline(always)]
            || {
                for &[a, b, c] in numbers {
                    let (found, expected) = (multiply_add(a, b, c), a.mul_add(b, c));
                    let same = found.to_bits() == expected.to_bits();
                    let same = same || found.is_nan() && expected.is_nan();
                    assert!(same, "{a:e} · {b:e} + {c:e} is {expected:e} and not {found:e}");
                }
            },
        );
    }

    /// Numbers with few digits, so that halves and cancellations are frequent, of all sizes.
    fn short() -> impl Strategy<Value = f32> {
        let size = prop_oneof![-149..128_i32, -40..40_i32, -80..-60_i32];
        (-4097..=4097_i32, size).prop_map(|(digits, size)| libm::ldexpf(digits as f32, size))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100_000))]

        #[test]
        fn all_numbers_are_multiplied_and_added_as_by_the_instruction(
            a in any::<u32>(), b in any::<u32>(), c in any::<u32>()
        ) {
            assert_fused(&[[a, b, c].map(f32::from_bits)]);
        }

        #[test]
        fn halves_are_rounded_as_by_the_instruction(a in short(), b in short(), c in short()) {
            assert_fused(&[[a, b, c]]);
        }

        #[test]
        fn what_nearly_cancels_is_rounded_as_by_the_instruction(
            a in short(), b in short(), ulps in -3..=3_i32
        ) {
            let c = -f32::from_bits((a * b).to_bits().wrapping_add_signed(ulps));
            assert_fused(&[[a, b, c]]);
        }
    }

    #[test]
    fn sums_of_a_network_s_size_are_rounded_as_by_the_instruction() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut draw = || rng.random_range(-1.0..1.0_f32);
        let numbers: Vec<_> = (0..1_000_000).map(|_| [draw(), draw(), draw()]).collect();
        assert_fused(&numbers);
        let least = f32::from_bits(1);
        let tiny = numbers.iter().map(|[a, b, c]| [a * 64.0, b * 64.0 * least, c * 64.0 * least]);
        assert_fused(&tiny.collect::<Vec<_>>());
    }
}
