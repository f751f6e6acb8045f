//! What the networks see: normalized observations and goals, alike objects in order of turn.

mod encoder;
mod normalize;
mod turns;

pub use encoder::InputEncoder;
pub use normalize::{CLIP, Normalizer, SMALLEST_DEVIATION};
