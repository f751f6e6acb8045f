//! Threads that know which process they are in.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::mem;
use std::process;

/// Threads that step environments.
///
/// A forked process has a copy of this value and none of the threads: whoever waited for them would
/// wait for ever. So they are started again in every process that uses them.
pub(crate) struct Threads {
    /// None where they could not be started again, and while this value is dropped.
    pool: Option<ThreadPool>,
    count: usize,
    process: u32,
}

impl Threads {
    /// Starts `count` threads.
    pub(crate) fn new(count: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self { pool: Some(start(count)?), count, process: process::id() })
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The threads of this process.
    pub(crate) fn here(&mut self) -> Result<&ThreadPool, ThreadPoolBuildError> {
        let Self { pool, count, process } = self;
        if *process != process::id() {
            // Dropping them would lock what a thread of the other process may have held.
            mem::forget(pool.take());
            *process = process::id();
        }
        match pool {
            Some(pool) => Ok(pool),
            None => Ok(pool.insert(start(*count)?)),
        }
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        if self.process != process::id() {
            mem::forget(self.pool.take());
        }
    }
}

fn start(count: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(count).build()
}
