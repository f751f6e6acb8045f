//! Replay of whole episodes.

mod prefetch;
mod ring;

#[cfg(feature = "train")]
pub(crate) use ring::frame_width;
pub use ring::{Replay, StepIndex};
