//! Asking for memory before it is needed.

#![cfg_attr(
    target_arch = "x86_64",
    expect(unsafe_code, reason = "there is no safe call for it; it reads nothing and cannot fail")
)]

/// Bytes that are fetched together on common processors.
pub(crate) const CACHE_LINE: usize = 64;

/// Has the cache line at `place` fetched; nothing waits for it.
///
/// Other processors than x86-64 find it out by themselves, or wait.
#[inline]
pub(crate) fn prefetch<T>(place: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};

        // SAFETY: any address may be prefetched, and every processor of this kind can do it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(place).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}
