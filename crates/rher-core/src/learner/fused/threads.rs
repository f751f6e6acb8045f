//! Work for one thread or for a pool, cut the same way for both.

/// Runs both, on two threads of the current pool when `parallel`.
pub(super) fn join<A: Send, B: Send>(
    parallel: bool,
    left: impl FnOnce() -> A + Send,
    right: impl FnOnce() -> B + Send,
) -> (A, B) {
    if parallel { rayon::join(left, right) } else { (left(), right()) }
}

/// Runs `work` on every item and its index, on the threads of the current pool when `parallel`.
pub(super) fn for_each<T: Send>(
    parallel: bool,
    items: &mut [T],
    work: &(impl Fn(usize, &mut T) + Sync),
) {
    for_each_from(0, parallel, items, work);
}

fn for_each_from<T: Send>(
    start: usize,
    parallel: bool,
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
                parallel,
                || for_each_from(start, parallel, left, work),
                || for_each_from(start + middle, parallel, right, work),
            );
        }
    }
}
