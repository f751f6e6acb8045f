//! Randomness: one seed, one stream for every purpose and every occasion.

use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// The seed of a run.
///
/// Every random draw comes from a `ChaCha8` stream that is a function of the seed, a purpose and a
/// count (of episodes, of updates).
/// So a run that is resumed needs no generator states, and the order in which threads happen to
/// work changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seed(pub u64);

/// What a stream is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Weights before the first update; one count.
    Init = 1,
    /// Environments of training, counted by episode.
    Environment = 2,
    /// Actions of training, counted by episode.
    Exploration = 3,
    /// Samples for the normalizer, counted by episode.
    Statistics = 4,
    /// Batches and the noise on target actions, counted by update.
    Batch = 5,
    /// Environments of evaluation, counted by episode.
    Evaluation = 6,
}

impl Seed {
    /// The stream of `purpose` for its `count`-th occasion.
    pub fn stream(self, purpose: Purpose, count: u64) -> ChaCha8Rng {
        const PURPOSE_SHIFT: u32 = 56;
        let mut rng = ChaCha8Rng::seed_from_u64(self.0);
        rng.set_stream((purpose as u64) << PURPOSE_SHIFT | count);
        rng
    }

    /// The seed of the `count`-th environment episode of `purpose`.
    pub fn episode(self, purpose: Purpose, count: u64) -> u64 {
        self.stream(purpose, count).next_u64()
    }
}
