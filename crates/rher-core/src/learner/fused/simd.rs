//! Which instructions the kernels use.

use pulp::{Arch, WithSimd};

/// The vector instructions of this machine, chosen when the program runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simd(Arch);

impl Simd {
    /// The best that the machine has, or none with `RHER_SIMD=portable` in the environment.
    pub(super) fn detect() -> Self {
        match std::env::var("RHER_SIMD") {
            Ok(choice) if choice == "portable" => Self(Arch::Scalar),
            _ => Self(Arch::new()),
        }
    }

    /// All that this machine has.
    #[cfg(test)]
    pub(super) fn every() -> Vec<Self> {
        let mut every = vec![Self(Arch::Scalar), Self(Arch::new())];
        #[cfg(target_arch = "x86_64")]
        every.extend(pulp::x86::V3::try_new().map(|avx2| Self(Arch::V3(avx2))));
        every
    }

    pub(super) fn arch(self) -> Arch {
        self.0
    }

    /// Runs plain loops compiled for these instructions; the closure must be `#[inline(always)]`.
    pub(super) fn run<R>(self, kernel: impl FnMut() -> R) -> R {
        self.0.dispatch(Kernel(kernel))
    }
}

struct Kernel<F>(F);

impl<R, F: FnMut() -> R> WithSimd for Kernel<F> {
    type Output = R;

    // A closure called by value goes through a shim that is not inlined.
    #[expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) -> R {
        (self.0)()
    }
}
