//! Products of bf16 numbers in plain loops: the bits that every other way must have.
#![expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]

use super::buffer::{LINE, padded};
use super::product::{PANEL, PairProduct};
use crate::learner::simd::Simd;

/// Rows of a tile: as many as leave registers for a row of the right matrix.
const TILE_ROWS: usize = 4;

/// The product in plain loops.
pub(super) fn multiply(simd: Simd, product: &mut PairProduct<'_>) {
    simd.run(
        #[inline(always)]
        || {
            for column in (0..product.columns).step_by(LINE) {
                for row in (0..product.rows).step_by(TILE_ROWS) {
                    match product.rows - row {
                        1 => multiply_tile::<1>(product, row, column),
                        2 => multiply_tile::<2>(product, row, column),
                        3 => multiply_tile::<3>(product, row, column),
                        _ => multiply_tile::<TILE_ROWS>(product, row, column),
                    }
                }
            }
        },
    );
}

/// Multiplies and adds in two steps, which is the same as in one: the products are exact.
#[inline(always)]
fn multiply_tile<const ROWS: usize>(product: &mut PairProduct<'_>, row: usize, column: usize) {
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
                sums[lane] += y * second[lane];
                sums[lane] += x * first[lane];
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
