//! What a matrix product is of, whoever computes it.

use super::pair::Pair;

/// One product `out = left · right`, or `out += left · right`.
///
/// Columns of `right` and `out` are next to each other; rows of `right` must be readable up to a
/// whole number of vectors.
pub(super) struct Product<'a> {
    /// `[rows, depth]`.
    pub(super) left: Left<'a, f32>,
    /// `[depth, columns]`, a row every `right_stride` numbers.
    pub(super) right: &'a [f32],
    pub(super) right_stride: usize,
    /// `[rows, columns]`, a row every `out_stride` numbers.
    pub(super) out: &'a mut [f32],
    pub(super) out_stride: usize,
    pub(super) rows: usize,
    pub(super) depth: usize,
    pub(super) columns: usize,
    /// Whether to add to what is there.
    pub(super) accumulate: bool,
}

/// Columns of a panel of a [`PairProduct`]: one that is 256 deep stays in the nearest cache.
pub(super) const PANEL: usize = 64;

/// One product `out = left · right`, or `out += left · right`, of pairs along the depth.
pub(super) struct PairProduct<'a> {
    /// `[rows, depth]`.
    pub(super) left: Left<'a, Pair>,
    /// `[depth, columns]` in panels of [`PANEL`] columns, the last one's width a whole number of
    /// vectors; each is stored by rows.
    pub(super) right: &'a [Pair],
    /// `[rows, columns]`, a row every `out_stride` numbers.
    pub(super) out: &'a mut [f32],
    pub(super) out_stride: usize,
    pub(super) rows: usize,
    /// In pairs.
    pub(super) depth: usize,
    pub(super) columns: usize,
    /// Whether to add to what is there.
    pub(super) accumulate: bool,
}

/// A matrix whose element (row, k) is at `row * row_stride + k * depth_stride`.
#[derive(Clone, Copy)]
pub(super) struct Left<'a, T> {
    pub(super) data: &'a [T],
    pub(super) row_stride: usize,
    pub(super) depth_stride: usize,
}

impl<'a, T: Copy> Left<'a, T> {
    /// A matrix that is stored by rows.
    pub(super) fn rows(data: &'a [T], stride: usize) -> Self {
        Self { data, row_stride: stride, depth_stride: 1 }
    }

    pub(super) fn at(self, row: usize, k: usize) -> T {
        self.data[row * self.row_stride + k * self.depth_stride]
    }

    /// The transpose of a matrix that is stored by rows.
    pub(super) fn transposed(data: &'a [T], stride: usize) -> Self {
        Self { data, row_stride: 1, depth_stride: stride }
    }
}
