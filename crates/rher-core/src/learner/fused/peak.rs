//! How fast this machine multiplies matrices: what the speed of an update is compared with.

use super::buffer::{Buffer, LINE};
use super::gemm::Gemm;
use super::pair::{self, Pair};
use super::pair_gemm::PairGemm;
use super::product::{Left, PANEL, PairProduct, Product};
use crate::config::Precision;
use crate::learner::simd::Simd;
use std::time::{Duration, Instant};

/// Floating-point operations per second of the engine's best product of `[rows, width]` and
/// `[width, width]`, on one thread with everything in its caches: the roof of an update.
///
/// Takes a tenth of a second.
pub fn gemm_peak(precision: Precision, rows: usize, width: usize) -> f64 {
    let simd = Simd::chosen_or_fastest();
    let width = width.next_multiple_of(LINE);
    // Zeros would take less power than a network's numbers.
    let numbers = |count| (0..count).map(|index| (index % 29) as f32 - 14.0).collect::<Vec<_>>();
    let left = Buffer::from(&*numbers(rows * width));
    let right = Buffer::from(&*numbers(width * width));
    let mut out = Buffer::zeros(rows * width);
    let best = match precision {
        Precision::F32 => best_time(|| {
            Gemm::new(simd).multiply(Product {
                left: Left::rows(&left, width),
                right: &right,
                right_stride: width,
                out: &mut out,
                out_stride: width,
                rows,
                depth: width,
                columns: width,
                accumulate: false,
            });
        }),
        Precision::Bf16 => {
            let depth = pair::pairs(width);
            let mut left_pairs = vec![Pair::default(); rows * depth];
            pair::pair_columns(&left, width, width, &mut left_pairs);
            let mut right_pairs = Buffer::zeros(depth * width);
            pair::pair_rows(&right, width, width, width, PANEL, &mut right_pairs);
            best_time(|| {
                PairGemm::new(simd).multiply(PairProduct {
                    left: Left::rows(&left_pairs, depth),
                    right: &right_pairs,
                    out: &mut out,
                    out_stride: width,
                    rows,
                    depth,
                    columns: width,
                    accumulate: false,
                });
            })
        }
    };
    2.0 * (rows * width * width) as f64 / best.as_secs_f64()
}

fn best_time(mut product: impl FnMut()) -> Duration {
    const PATIENCE: Duration = Duration::from_millis(100);
    // One product is over before a clock speed can change.
    const PRODUCTS: u32 = 16;
    let start = Instant::now();
    let mut best = Duration::MAX;
    while start.elapsed() < PATIENCE {
        let products_start = Instant::now();
        for _ in 0..PRODUCTS {
            product();
        }
        best = best.min(products_start.elapsed() / PRODUCTS);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_above_a_toy_s() {
        for precision in Precision::ALL {
            assert!(gemm_peak(*precision, 256, 256) > 1e8);
        }
    }
}
