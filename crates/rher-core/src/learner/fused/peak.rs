//! How fast this machine multiplies matrices: what the speed of an update is compared with.

use super::buffer::{Buffer, LINE};
use super::gemm::Gemm;
use super::product::{Left, Product};
use super::simd::Simd;
use std::time::{Duration, Instant};

/// Floating-point operations per second of the engine's best product of `[rows, width]` and
/// `[width, width]`, on one thread with everything in its caches: the roof of an update.
///
/// Takes a tenth of a second.
pub fn gemm_peak(rows: usize, width: usize) -> f64 {
    const PATIENCE: Duration = Duration::from_millis(100);
    // One product is over before a clock speed can change.
    const PRODUCTS: usize = 16;
    let gemm = Gemm::new(Simd::detect());
    let width = width.next_multiple_of(LINE);
    // Zeros would take less power than a network's numbers.
    let numbers = |count| (0..count).map(|index| (index % 29) as f32 - 14.0).collect::<Vec<_>>();
    let left = Buffer::from(&*numbers(rows * width));
    let right = Buffer::from(&*numbers(width * width));
    let mut out = Buffer::zeros(rows * width);
    let start = Instant::now();
    let mut best = Duration::MAX;
    while start.elapsed() < PATIENCE {
        let products_start = Instant::now();
        for _ in 0..PRODUCTS {
            gemm.multiply(Product {
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
        }
        best = best.min(products_start.elapsed() / PRODUCTS as u32);
    }
    2.0 * (rows * width * width) as f64 / best.as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_above_a_toy_s() {
        assert!(gemm_peak(256, 256) > 1e8);
    }
}
