//! Which vector instructions the networks are computed with.

use pulp::Arch;
use std::env::{self, VarError};
use std::sync::OnceLock;

/// The environment variable that chooses them.
const VARIABLE: &str = "RHER_SIMD";

/// The vector instructions that this process uses.
///
/// All of them compute the same bits; they differ in speed.
#[derive(Clone, Copy, Debug)]
pub struct Simd(Arch);

/// `RHER_SIMD` names no instructions that this machine has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`RHER_SIMD` is `{asked}`, and this machine has {}; leave it unset for the fastest",
    available.join(", ")
)]
pub struct SimdError {
    /// The value of the variable.
    asked: String,
    /// The values that it may have.
    available: Vec<&'static str>,
}

impl Simd {
    /// What `RHER_SIMD` in the environment names, and without it the fastest that the machine has.
    ///
    /// The environment is read once, by the first call.
    ///
    /// # Errors
    ///
    /// When the machine does not have what the variable names.
    pub fn chosen() -> Result<Self, SimdError> {
        static CHOSEN: OnceLock<Result<Simd, SimdError>> = OnceLock::new();
        let read = || match env::var(VARIABLE) {
            Ok(asked) => Self::named(&asked),
            Err(VarError::NotPresent) => Ok(Self::fastest()),
            Err(VarError::NotUnicode(asked)) => Self::named(&asked.to_string_lossy()),
        };
        CHOSEN.get_or_init(read).clone()
    }

    /// [`Simd::chosen`], and the fastest where that is an error: for networks that cannot report
    /// it. Whoever starts them has called [`Simd::chosen`] before.
    pub(crate) fn chosen_or_fastest() -> Self {
        Self::chosen().unwrap_or_else(|_| Self::fastest())
    }

    /// All that this machine has, the fastest first.
    pub fn every() -> Vec<Self> {
        let mut every = vec![Self::fastest()];
        #[cfg(target_arch = "x86_64")]
        if let (Arch::V4(_), Some(avx2)) = (every[0].0, pulp::x86::V3::try_new()) {
            every.push(Self(Arch::V3(avx2)));
        }
        if !matches!(every[0].0, Arch::Scalar) {
            every.push(Self(Arch::Scalar));
        }
        every
    }

    /// As `RHER_SIMD` has it: `avx512`, `avx2`, `neon`, `simd128`, or `portable` for plain loops.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Arch::V4(_) => "avx512",
            #[cfg(target_arch = "x86_64")]
            Arch::V3(_) => "avx2",
            #[cfg(target_arch = "aarch64")]
            Arch::Neon(_) => "neon",
            #[cfg(target_arch = "wasm32")]
            Arch::Simd128(_) => "simd128",
            _ => "portable",
        }
    }

    fn fastest() -> Self {
        Self(Arch::new())
    }

    fn named(asked: &str) -> Result<Self, SimdError> {
        let every = Self::every();
        every.iter().copied().find(|simd| simd.name() == asked).ok_or_else(|| SimdError {
            asked: asked.to_owned(),
            available: every.into_iter().map(Self::name).collect(),
        })
    }

    pub(super) fn arch(self) -> Arch {
        self.0
    }

    /// Runs plain loops compiled for these instructions; the closure must be `#[inline(always)]`.
    #[cfg(feature = "fused")]
    pub(super) fn run<R>(self, kernel: impl FnMut() -> R) -> R {
        self.0.dispatch(Kernel(kernel))
    }
}

#[cfg(feature = "fused")]
struct Kernel<F>(F);

#[cfg(feature = "fused")]
impl<R, F: FnMut() -> R> pulp::WithSimd for Kernel<F> {
    type Output = R;

    // A closure called by value goes through a shim that is not inlined.
    #[expect(clippy::inline_always, reason = "vector instructions reach only what is inlined")]
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) -> R {
        (self.0)()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instructions_are_chosen_by_name() {
        for simd in Simd::every() {
            assert_eq!(Simd::named(simd.name()).unwrap().name(), simd.name());
        }
        assert_eq!(Simd::named("portable").unwrap().name(), "portable");
        let error = Simd::named("mmx").unwrap_err().to_string();
        assert!(error.contains("`mmx`") && error.contains("portable"), "{error}");
        assert!(error.contains(Simd::fastest().name()), "{error}");
    }
}
