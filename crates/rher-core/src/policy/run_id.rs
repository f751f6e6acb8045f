//! Which run a file is of.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Digits of an identity as text.
const DIGITS: usize = 32;

/// Identity of a run: a hash of its task, its settings and its seed.
///
/// Two runs with the same settings have the same identity and, since they repeat bit for bit, the
/// same files. How long a run is and which engine computes it are no part of it, because a run may
/// be resumed with others. As text it has 32 hexadecimal digits.
///
/// ```
/// use rher_core::RunId;
///
/// let id: RunId = "00112233445566778899aabbccddeeff".parse().unwrap();
/// assert_eq!(id.to_string(), "00112233445566778899aabbccddeeff");
/// assert!("0011".parse::<RunId>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct RunId(pub(crate) u128);

/// A text is not the identity of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the identity of a run has {DIGITS} lower-case hexadecimal digits")]
pub struct NoRunId;

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl FromStr for RunId {
    type Err = NoRunId;

    fn from_str(text: &str) -> Result<Self, NoRunId> {
        let is_digit = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
        if text.len() != DIGITS || !text.bytes().all(is_digit) {
            return Err(NoRunId);
        }
        u128::from_str_radix(text, 16).map(Self).map_err(|_| NoRunId)
    }
}

impl TryFrom<String> for RunId {
    type Error = NoRunId;

    fn try_from(text: String) -> Result<Self, NoRunId> {
        text.parse()
    }
}

impl From<RunId> for String {
    fn from(id: RunId) -> Self {
        id.to_string()
    }
}
