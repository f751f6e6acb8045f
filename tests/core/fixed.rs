//! A generator that draws what a test wants.

use rand::TryRng;
use std::convert::Infallible;

/// A generator whose every draw is the same share of the whole, and how often it was asked.
pub(crate) struct Fixed {
    share: f64,
    pub(crate) draws: usize,
}

impl TryRng for Fixed {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.draws += 1;
        Ok((self.share * (1_u64 << 32) as f64) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.draws += 1;
        Ok((self.share * (1_u128 << 64) as f64) as u64)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        unreachable!("nobody draws {} bytes", bytes.len())
    }
}

pub(crate) fn fixed(share: f64) -> Fixed {
    Fixed { share, draws: 0 }
}
