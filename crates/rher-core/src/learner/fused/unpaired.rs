//! Products of pairs of bf16 numbers by the micro-kernels for `f32`.
//!
//! Every product of two is exact ([`pair`](super::pair)), so a fused multiplication and addition
//! for each number of a pair, the second before the first, has the bits of one for both.
#![expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]

use super::buffer::{Buffer, padded};
use super::gemm::Gemm;
use super::pair::Pair;
use super::product::{Left, PANEL, PairProduct, Product};
use crate::learner::simd::Simd;
use std::cell::RefCell;

thread_local! {
    static MEMORY: RefCell<Memory> = RefCell::new(Memory {
        left: Buffer::zeros(0),
        right: Buffer::zeros(0),
    });
}

/// The numbers of both matrices; grown to the largest product of the thread.
struct Memory {
    left: Buffer,
    right: Buffer,
}

/// Writes the product over its `out`, or adds it.
pub(super) fn multiply(simd: Simd, gemm: Gemm, product: PairProduct<'_>) {
    let PairProduct { left, right, out, out_stride, rows, depth, columns, accumulate } = product;
    let by_rows = left.depth_stride == 1;
    let stride = if by_rows { 2 * depth } else { left.depth_stride };
    let left_length = stride * if by_rows { rows } else { 2 * depth };
    let right = &right[..depth * padded(columns)];
    MEMORY.with_borrow_mut(|memory| {
        let to_left = of_length(&mut memory.left, left_length);
        let to_right = of_length(&mut memory.right, 2 * right.len());
        simd.run(
            #[inline(always)]
            || {
                if by_rows {
                    let rows = left.data.chunks(left.row_stride);
                    for (row, to) in rows.zip(to_left.chunks_exact_mut(stride)) {
                        unpair(&row[..depth], to);
                    }
                } else {
                    unpair_rows(left.data, stride, to_left);
                }
                for start in (0..columns).step_by(PANEL) {
                    let width = padded(columns - start).min(PANEL);
                    let panel = depth * start..depth * (start + width);
                    let to = &mut to_right[2 * panel.start..2 * panel.end];
                    unpair_rows(&right[panel], width, to);
                }
            },
        );
        for start in (0..columns).step_by(PANEL) {
            gemm.multiply(Product {
                left: if by_rows {
                    Left::rows(to_left, stride)
                } else {
                    Left::transposed(to_left, stride)
                },
                right: &to_right[2 * depth * start..],
                right_stride: padded(columns - start).min(PANEL),
                out: &mut out[start..],
                out_stride,
                rows,
                depth: 2 * depth,
                columns: PANEL.min(columns - start),
                accumulate,
            });
        }
    });
}

fn of_length(buffer: &mut Buffer, length: usize) -> &mut [f32] {
    if buffer.len() < length {
        *buffer = Buffer::zeros(length);
    }
    &mut buffer[..length]
}

/// The numbers of a row of pairs, the second of each before the first.
#[inline(always)]
fn unpair(pairs: &[Pair], to: &mut [f32]) {
    for (pair, to) in pairs.iter().zip(to.as_chunks_mut().0) {
        let (first, second) = pair.numbers();
        *to = [second, first];
    }
}

/// Rows of `width` pairs as two rows of numbers each, the second numbers before the first.
#[inline(always)]
fn unpair_rows(pairs: &[Pair], width: usize, to: &mut [f32]) {
    for (pairs, to) in pairs.chunks(width).zip(to.chunks_exact_mut(2 * width)) {
        let (seconds, firsts) = to.split_at_mut(width);
        for ((pair, second), first) in pairs.iter().zip(seconds).zip(firsts) {
            (*first, *second) = pair.numbers();
        }
    }
}
