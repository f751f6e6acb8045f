//! What the networks see: normalized observations and goals, near distances on a finer scale, and
//! alike objects in order of turn, from the order that promises most.

mod distances;
mod encoder;
mod fine_scale;
mod normalize;
mod order;
mod turns;

pub use encoder::InputEncoder;
pub use normalize::{CLIP, Normalizer, SMALLEST_DEVIATION};
#[cfg(feature = "train")]
pub(crate) use order::{Attempt, OrderModel};
