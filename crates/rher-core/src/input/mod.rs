//! What the networks see: normalized observations and goals, alike objects in order of turn, and
//! near distances on a finer scale.

mod encoder;
mod fine_scale;
mod normalize;
mod turns;

pub use encoder::InputEncoder;
pub use normalize::{CLIP, Normalizer, SMALLEST_DEVIATION};
