//! Flat buffers that start on a cache line.

use std::ops::{Deref, DerefMut};

/// Numbers in a cache line, and in the widest vector of any machine.
pub(super) const LINE: usize = 16;

/// The width of a matrix whose rows are whole vectors.
pub(super) fn padded(width: usize) -> usize {
    width.next_multiple_of(LINE)
}

/// A slice of fixed length whose first element starts a cache line.
#[derive(Debug)]
pub(super) struct Buffer<T = f32> {
    memory: Vec<T>,
    start: usize,
    length: usize,
}

impl<T: Copy + Default> Buffer<T> {
    /// For elements of four bytes, as all are.
    pub(super) fn zeros(length: usize) -> Self {
        const { assert!(size_of::<T>() == size_of::<f32>()) }
        let memory = vec![T::default(); length + LINE - 1];
        let start = memory.as_ptr().align_offset(LINE * size_of::<f32>()).min(LINE - 1);
        Self { memory, start, length }
    }
}

impl From<&[f32]> for Buffer {
    fn from(values: &[f32]) -> Self {
        let mut buffer = Self::zeros(values.len());
        buffer.copy_from_slice(values);
        buffer
    }
}

impl<T> Deref for Buffer<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.memory[self.start..][..self.length]
    }
}

impl<T> DerefMut for Buffer<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.memory[self.start..][..self.length]
    }
}
