//! Matrix products for machines without a vector unit that the micro-kernels know.
//!
//! The bits are those of the micro-kernels: a sum starts at zero, takes its fused products in their
//! order, and is added to what is there at the end.

use super::fma::multiply_add;
use super::product::Product;

/// Rows and columns of a tile.
const TILE: (usize, usize) = (4, 8);

/// Writes the product over its `out`, or adds it.
pub(super) fn multiply(product: &mut Product<'_>) {
    let (tile_rows, tile_columns) = TILE;
    for column in (0..product.columns).step_by(tile_columns) {
        for row in (0..product.rows).step_by(tile_rows) {
            if row + tile_rows <= product.rows && column + tile_columns <= product.columns {
                multiply_tile(product, row, column);
            } else {
                multiply_edge(product, row, column);
            }
        }
    }
}

fn multiply_tile(product: &mut Product<'_>, row: usize, column: usize) {
    let left = product.left;
    let mut tile = [[0.0; TILE.1]; TILE.0];
    for k in 0..product.depth {
        let right = &product.right[k * product.right_stride + column..][..TILE.1];
        for (index, sums) in tile.iter_mut().enumerate() {
            let x = left.at(row + index, k);
            for (sum, y) in sums.iter_mut().zip(right) {
                *sum = multiply_add(x, *y, *sum);
            }
        }
    }
    let accumulate = product.accumulate;
    for (index, sums) in tile.iter().enumerate() {
        let out = &mut product.out[(row + index) * product.out_stride + column..][..TILE.1];
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = if accumulate { *out + sum } else { *sum };
        }
    }
}

/// A tile that is cut by the matrix's end.
fn multiply_edge(product: &mut Product<'_>, row: usize, column: usize) {
    for row in row..product.rows.min(row + TILE.0) {
        for column in column..product.columns.min(column + TILE.1) {
            let right = product.right[column..].iter().step_by(product.right_stride);
            let sum = right
                .take(product.depth)
                .enumerate()
                .fold(0.0, |sum, (k, y)| multiply_add(product.left.at(row, k), *y, sum));
            let out = &mut product.out[row * product.out_stride + column];
            *out = if product.accumulate { *out + sum } else { sum };
        }
    }
}
