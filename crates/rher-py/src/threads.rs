//! How many threads this process may use.

use std::num::NonZeroUsize;
use std::thread::available_parallelism;

/// The processors that this process is allowed to use: its affinity and the quota of its control
/// group count, not the number of processors that the machine has.
pub(crate) fn allowed() -> usize {
    available_parallelism().map_or(1, NonZeroUsize::get)
}
