//! JSON schemas of the program's own messages.

pub(crate) const BEGIN: &str = include_str!("schemas/episode.json");
pub(crate) const FRAME: &str = include_str!("schemas/frame.json");
pub(crate) const ACTION: &str = include_str!("schemas/action.json");
#[cfg(feature = "live")]
pub(crate) const METRICS: &str = include_str!("schemas/metrics.json");
