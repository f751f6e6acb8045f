//! Work for one thread or for a pool, cut the same way for both.

/// Which threads an update uses.
#[derive(Clone, Copy, Debug)]
pub(super) enum Threads {
    /// The caller's alone.
    Caller,
    /// Those of the rayon pool that the caller's thread belongs to.
    Pool,
}

impl Threads {
    /// The pool of the current thread, if it belongs to one.
    pub(super) fn current() -> Self {
        if rayon::current_thread_index().is_some() { Self::Pool } else { Self::Caller }
    }
}

/// Runs both, on two threads if there is a pool.
pub(super) fn join<A: Send, B: Send>(
    threads: Threads,
    left: impl FnOnce() -> A + Send,
    right: impl FnOnce() -> B + Send,
) -> (A, B) {
    match threads {
        Threads::Caller => (left(), right()),
        Threads::Pool => rayon::join(left, right),
    }
}

/// Runs `work` on every item and its index.
pub(super) fn for_each<T: Send>(
    threads: Threads,
    items: &mut [T],
    work: &(impl Fn(usize, &mut T) + Sync),
) {
    for_each_from(0, threads, items, work);
}

fn for_each_from<T: Send>(
    start: usize,
    threads: Threads,
    items: &mut [T],
    work: &(impl Fn(usize, &mut T) + Sync),
) {
    match items {
        [] => {}
        [item] => work(start, item),
        _ => {
            let middle = items.len() / 2;
            let (left, right) = items.split_at_mut(middle);
            join(
                threads,
                || for_each_from(start, threads, left, work),
                || for_each_from(start + middle, threads, right, work),
            );
        }
    }
}
