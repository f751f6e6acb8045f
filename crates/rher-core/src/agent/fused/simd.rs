//! Which instructions the kernels use.

use pulp::{Arch, NullaryFnOnce};

/// The vector instructions of this machine, chosen when the program runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simd(Arch);

impl Simd {
    /// The best that the machine has, or none with `RHER_SIMD=portable` in the environment.
    pub(super) fn detect() -> Self {
        match std::env::var("RHER_SIMD") {
            Ok(choice) if choice == "portable" => Self::portable(),
            _ => Self(Arch::new()),
        }
    }

    /// Only what every machine has.
    pub(super) fn portable() -> Self {
        Self(Arch::Scalar)
    }

    pub(super) fn arch(self) -> Arch {
        self.0
    }

    /// Runs plain loops compiled for these instructions.
    pub(super) fn run<F: NullaryFnOnce>(self, kernel: F) -> F::Output {
        self.0.dispatch(kernel)
    }
}
