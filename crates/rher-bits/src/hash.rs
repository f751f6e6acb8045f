//! Hashes of numbers.

use rher_core::learner::state::{LearnerState, Trained};
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;

/// Takes numbers, and nothing but their bits.
#[derive(Default)]
pub(crate) struct Bits(Sha256);

impl Bits {
    pub(crate) fn numbers(&mut self, numbers: impl IntoIterator<Item = f32>) {
        for number in numbers {
            self.0.update(number.to_bits().to_le_bytes());
        }
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    pub(crate) fn learner(&mut self, state: &LearnerState) {
        for trained in state.critics.iter().chain([&state.actor]) {
            let Trained { online, target, first_moment, second_moment, .. } = trained;
            for numbers in [online, target, first_moment, second_moment] {
                self.numbers(numbers.iter().copied());
            }
        }
    }

    /// The first eight bytes in hexadecimal digits.
    pub(crate) fn hash(self) -> String {
        self.0.finalize().iter().take(8).fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
    }
}

/// The hash of the tensors in the bytes of a policy file; `None` if these are no such file.
pub fn tensors(policy: &[u8]) -> Option<String> {
    let (length, rest) = policy.split_first_chunk()?;
    let mut bits = Bits::default();
    bits.bytes(rest.get(usize::try_from(u64::from_le_bytes(*length)).ok()?..)?);
    Some(bits.hash())
}
