//! Products of bf16 numbers by `VDPBF16PS`.
//!
//! No crate has this micro-kernel for operands that are packed once and used often.
#![expect(unsafe_code, reason = "the kernel takes pointers; `multiply` checks what they reach")]

use super::buffer::{LINE, padded};
use super::emulated;
use super::pair::Pair;
use super::product::{Left, PANEL, PairProduct};
use crate::learner::simd::Simd;
use pulp::Arch;
use pulp::core_arch::x86::Avx512bf16;
use std::arch::x86_64::{
    __m512bh, __m512i, _mm512_add_ps, _mm512_dpbf16_ps, _mm512_loadu_si512, _mm512_mask_storeu_ps,
    _mm512_maskz_loadu_ps, _mm512_set1_epi32, _mm512_setzero_ps,
};
use std::sync::OnceLock;

/// Proves that the processor has the instruction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dot(Avx512bf16);

/// One tile of a product; strides are in elements.
#[derive(Clone, Copy)]
struct Tile {
    depth: usize,
    left: *const Pair,
    row_stride: usize,
    depth_stride: usize,
    right: *const Pair,
    right_stride: usize,
    out: *mut f32,
    out_stride: usize,
    /// The columns of the last vector that are written.
    last: u16,
    accumulate: bool,
}

type Kernel = unsafe fn(Tile);

/// Rows of a full tile; with four vectors in each, the sums fill 24 of 32 registers.
const TILE_ROWS: usize = 6;

/// By vectors in a tile's row, then by rows in a tile.
static KERNELS: [[Kernel; TILE_ROWS]; PANEL / LINE] =
    [kernels_of::<1>(), kernels_of::<2>(), kernels_of::<3>(), kernels_of::<4>()];

const fn kernels_of<const VECTORS: usize>() -> [Kernel; TILE_ROWS] {
    [
        multiply_tile::<1, VECTORS>,
        multiply_tile::<2, VECTORS>,
        multiply_tile::<3, VECTORS>,
        multiply_tile::<4, VECTORS>,
        multiply_tile::<5, VECTORS>,
        multiply_tile::<6, VECTORS>,
    ]
}

impl Dot {
    pub(super) fn find(simd: Simd) -> Option<Self> {
        static AGREES: OnceLock<bool> = OnceLock::new();
        if !matches!(simd.arch(), Arch::V4(_)) {
            return None;
        }
        let dot = Self(Avx512bf16::try_new()?);
        AGREES.get_or_init(|| dot.agrees(simd)).then_some(dot)
    }

    /// Whether more than ten thousand steps of random numbers have the bits of the plain loops.
    fn agrees(self, simd: Simd) -> bool {
        const ROWS: usize = 20;
        const DEPTH: usize = 8;
        const COLUMNS: usize = 100;
        let mut state = 1_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let bits = (state >> 32) as u32;
            // The sign and fraction, and an exponent from −60 to 29: some are rounded to 0.
            f32::from_bits(bits & 0x807f_ffff | (67 + (bits >> 23) % 90) << 23)
        };
        let mut draw_pairs =
            |count| (0..count).map(|_| Pair::new(draw(), draw())).collect::<Vec<_>>();
        let left = draw_pairs(ROWS * DEPTH);
        let right = draw_pairs(DEPTH * padded(COLUMNS));
        let product = |out| PairProduct {
            left: Left::rows(&left, DEPTH),
            right: &right,
            out,
            out_stride: COLUMNS,
            rows: ROWS,
            depth: DEPTH,
            columns: COLUMNS,
            accumulate: true,
        };
        let (mut found, mut expected) = ([0.5; ROWS * COLUMNS], [0.5; ROWS * COLUMNS]);
        self.multiply(product(&mut found));
        emulated::multiply(simd, &mut product(&mut expected));
        found.iter().zip(&expected).all(|(x, y)| x.to_bits() == y.to_bits())
    }

    pub(super) fn multiply(self, product: PairProduct<'_>) {
        let Self(_has_the_instructions) = self;
        let PairProduct { left, right, out, out_stride, rows, depth, columns, accumulate } =
            product;
        if rows == 0 || depth == 0 || columns == 0 {
            return;
        }
        assert!((rows - 1) * left.row_stride + (depth - 1) * left.depth_stride < left.data.len());
        assert!(depth * padded(columns) <= right.len());
        assert!((rows - 1) * out_stride + columns <= out.len());

        for column in (0..columns).step_by(PANEL) {
            let width = PANEL.min(columns - column);
            let kernels = &KERNELS[width.div_ceil(LINE) - 1];
            for row in (0..rows).step_by(TILE_ROWS) {
                let height = TILE_ROWS.min(rows - row);
                // SAFETY: `self` proves the instructions. The kernel reads `height` rows of
                // `left` and a panel of `right`, `[depth, padded(width)]`, and accesses `height`
                // rows of `width` numbers of `out`: all inside by the assertions.
                unsafe {
                    kernels[height - 1](Tile {
                        depth,
                        left: left.data.as_ptr().add(row * left.row_stride),
                        row_stride: left.row_stride,
                        depth_stride: left.depth_stride,
                        right: right.as_ptr().add(column * depth),
                        right_stride: padded(width),
                        out: out.as_mut_ptr().add(row * out_stride + column),
                        out_stride,
                        last: u16::MAX >> (padded(width) - width),
                        accumulate,
                    });
                }
            }
        }
    }
}

/// # Safety
///
/// The processor has the instructions. `left` can be read at `ROWS` rows of `depth` pairs,
/// `right` at `depth` rows of `VECTORS` vectors; `out` can be read and written at `ROWS` rows
/// of as many vectors, in the last of which at the columns in `last`.
#[target_feature(enable = "avx512f,avx512bf16")]
unsafe fn multiply_tile<const ROWS: usize, const VECTORS: usize>(tile: Tile) {
    let Tile { depth, mut left, mut right, out, .. } = tile;
    let mut sums = [[_mm512_setzero_ps(); VECTORS]; ROWS];
    for _ in 0..depth {
        // SAFETY: as the function demands, in the k-th row and column.
        unsafe {
            let vectors: [__m512bh; VECTORS] =
                std::array::from_fn(|v| pairs_of(_mm512_loadu_si512(right.add(v * LINE).cast())));
            for (row, sums) in sums.iter_mut().enumerate() {
                let pair = left.add(row * tile.row_stride).cast::<i32>().read();
                let pair = pairs_of(_mm512_set1_epi32(pair));
                for (sum, vector) in sums.iter_mut().zip(&vectors) {
                    *sum = _mm512_dpbf16_ps(*sum, pair, *vector);
                }
            }
        }
        left = left.wrapping_add(tile.depth_stride);
        right = right.wrapping_add(tile.right_stride);
    }
    for (row, sums) in sums.iter().enumerate() {
        for (v, sum) in sums.iter().enumerate() {
            let columns = if v + 1 == VECTORS { tile.last } else { u16::MAX };
            // SAFETY: as the function demands.
            unsafe {
                let out = out.add(row * tile.out_stride + v * LINE);
                let sum = if tile.accumulate {
                    _mm512_add_ps(_mm512_maskz_loadu_ps(columns, out), *sum)
                } else {
                    *sum
                };
                _mm512_mask_storeu_ps(out, columns, sum);
            }
        }
    }
}

/// The same bits as another type.
#[target_feature(enable = "avx512f")]
fn pairs_of(bits: __m512i) -> __m512bh {
    // SAFETY: both are 512 plain bits.
    unsafe { std::mem::transmute(bits) }
}
