//! Replay of whole episodes.

mod prefetch;
mod ring;

pub use ring::{Replay, StepIndex};
