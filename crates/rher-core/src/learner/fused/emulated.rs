//! Products of bf16 numbers in plain loops: the bits that every other way must have.
#![expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]

use super::buffer::{LINE, padded};
use super::product::{PANEL, PairProduct};
use crate::learner::simd::Simd;
use pulp::Arch;

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
#[expect(clippy::disallowed_methods, reason = "chosen where it is an instruction")]
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
        let (mut first, mut second) = ([0.0; LINE], [0.0; LINE]);
        for lane in 0..LINE {
            (first[lane], second[lane]) = right[lane].numbers();
        }
        for (index, sums) in tile.iter_mut().enumerate() {
            let (x, y) = product.left.at(row + index, k).numbers();
            for lane in 0..LINE {
                sums[lane] = add_product::<FUSED>(y, second[lane], sums[lane]);
                sums[lane] = add_product::<FUSED>(x, first[lane], sums[lane]);
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
