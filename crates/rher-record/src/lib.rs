//! Episodes as MCAP recordings that Foxglove opens without any set-up, as proofs, and as datasets.
//!
//! An [`ActionLog`](rher_core::explore::ActionLog) is all that an episode depends on; [`Player`] plays
//! it again in a separate environment and describes it in timed [`Message`](message::Message)s, which a
//! [`RecordingFile`] keeps. [`Recording`] reads them back one episode at a time, and
//! [`verify`](verify::verify) plays them once more to prove that they were real.

pub mod export;
mod file;
mod info;
#[cfg(feature = "live")]
mod live;
pub mod message;
mod paint;
mod part;
mod player;
mod read;
mod recorder;
mod records;
mod schemas;
#[cfg(test)]
mod tests;
pub mod verify;

pub use file::{LAYOUT, RecordingFile, layout_beside};
pub use info::{InfoError, RecordingInfo, Source};
#[cfg(feature = "live")]
pub use live::{Live, LiveError};
pub use player::{PlayError, Played, Player};
pub use read::{ReadError, Recorded, Recording, Sent};
pub use recorder::{Recorder, RecorderError};
