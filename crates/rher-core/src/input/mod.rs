//! What the networks see: normalized observations and goals, near distances on a finer scale, and
//! alike objects in order of turn, from the order that promises most.

mod distances;
mod encoder;
mod fine_scale;
mod normalize;
mod order;
mod turns;

#[cfg(feature = "onnx")]
pub(crate) use distances::{Point, Way, ways};
pub use encoder::InputEncoder;
#[cfg(feature = "onnx")]
pub(crate) use fine_scale::{FAR, FineScale, NEAR};
pub use normalize::{CLIP, Normalizer, SMALLEST_DEVIATION};
#[cfg(feature = "train")]
pub(crate) use order::Attempt;
#[cfg(any(feature = "onnx", feature = "train"))]
pub(crate) use order::OrderModel;
#[cfg(feature = "onnx")]
pub(crate) use turns::Turns;
