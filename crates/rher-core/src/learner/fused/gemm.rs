//! Matrix products on the micro-kernels of the `gemm` crate.
//!
//! The crate's own driver allocates in every call and packs operands that are laid out well here
//! already, so this file walks over the tiles itself.
#![expect(
    unsafe_code,
    reason = "the micro-kernels take pointers; `multiply` checks what they reach"
)]

use super::portable;
use super::product::Product;
use crate::learner::simd::Simd;
use gemm_f32::microkernel;
use pulp::Arch;

/// How products are computed on this machine.
#[derive(Clone, Copy, Debug)]
pub(super) enum Gemm {
    /// By the crate's micro-kernels.
    Vectors(Kernels),
    /// By plain loops.
    Portable,
}

/// The micro-kernels for one set of vector instructions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernels {
    /// By vectors in a tile's row, then by rows in a tile.
    table: &'static [Kernel],
    /// Rows in a full tile.
    tile_rows: usize,
    /// Numbers in a vector.
    lanes: usize,
}

/// Rows and columns swapped: for the crate, columns of `right` are rows and lie next to each other.
type Kernel = unsafe fn(
    m: usize,
    n: usize,
    k: usize,
    dst: *mut f32,
    lhs: *const f32,
    rhs: *const f32,
    dst_cs: isize,
    dst_rs: isize,
    lhs_cs: isize,
    rhs_rs: isize,
    rhs_cs: isize,
    alpha: f32,
    beta: f32,
    alpha_status: u8,
    conj_dst: bool,
    conj_lhs: bool,
    conj_rhs: bool,
    next_lhs: *const f32,
);

impl Gemm {
    pub(super) fn new(simd: Simd) -> Self {
        match simd.arch() {
            #[cfg(target_arch = "x86_64")]
            Arch::V4(_) => {
                use microkernel::avx512f::f32::{MR_DIV_N, NR, UKR};
                static KERNELS: [[Kernel; NR]; MR_DIV_N] = UKR;
                Self::Vectors(Kernels { table: KERNELS.as_flattened(), tile_rows: NR, lanes: 16 })
            }
            #[cfg(target_arch = "x86_64")]
            Arch::V3(_) => {
                use microkernel::fma::f32::{MR_DIV_N, NR, UKR};
                static KERNELS: [[Kernel; NR]; MR_DIV_N] = UKR;
                Self::Vectors(Kernels { table: KERNELS.as_flattened(), tile_rows: NR, lanes: 8 })
            }
            #[cfg(target_arch = "aarch64")]
            Arch::Neon(_) => {
                use microkernel::neon::f32::{MR_DIV_N, NR, UKR};
                static KERNELS: [[Kernel; NR]; MR_DIV_N] = UKR;
                Self::Vectors(Kernels { table: KERNELS.as_flattened(), tile_rows: NR, lanes: 4 })
            }
            _ => Self::Portable,
        }
    }

    /// Writes the product over its `out`, or adds it.
    pub(super) fn multiply(self, mut product: Product<'_>) {
        match self {
            Self::Vectors(kernels) => kernels.multiply(product),
            Self::Portable => portable::multiply(&mut product),
        }
    }
}

impl Kernels {
    fn multiply(self, product: Product<'_>) {
        let Product { left, right, right_stride, out, out_stride, rows, depth, columns, .. } =
            product;
        // To the kernels, 0 is to write and 1 is to add.
        let status = u8::from(product.accumulate);
        if rows == 0 || depth == 0 || columns == 0 {
            return;
        }
        assert!((rows - 1) * left.row_stride + (depth - 1) * left.depth_stride < left.data.len());
        assert!((depth - 1) * right_stride + columns.next_multiple_of(self.lanes) <= right.len());
        assert!((rows - 1) * out_stride + columns <= out.len());

        let tile_columns = self.table.len() / self.tile_rows * self.lanes;
        for column in (0..columns).step_by(tile_columns) {
            let width = tile_columns.min(columns - column);
            let kernels = &self.table[(width.div_ceil(self.lanes) - 1) * self.tile_rows..];
            for row in (0..rows).step_by(self.tile_rows) {
                let height = self.tile_rows.min(rows - row);
                // SAFETY: the table was chosen by a token that proves the instructions. The kernel
                // reads `height` rows of `left` and `depth` rows of whole vectors of `right`, and
                // writes `height` rows of `width` numbers of `out`: all inside by the assertions.
                unsafe {
                    kernels[height - 1](
                        width,
                        height,
                        depth,
                        out.as_mut_ptr().add(row * out_stride + column),
                        right.as_ptr().add(column),
                        left.data.as_ptr().add(row * left.row_stride),
                        out_stride.cast_signed(),
                        1,
                        right_stride.cast_signed(),
                        left.depth_stride.cast_signed(),
                        left.row_stride.cast_signed(),
                        1.0,
                        1.0,
                        status,
                        false,
                        false,
                        false,
                        std::ptr::null(),
                    );
                }
            }
        }
    }
}
