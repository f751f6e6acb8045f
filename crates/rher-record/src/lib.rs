//! Episodes as MCAP recordings that Foxglove opens without any set-up, as proofs, and as datasets.
//!
//! A [`ActionLog`](rher_core::explore::ActionLog) is all that an episode depends on; [`Player`] plays it
//! again in an environment of its own and tells it as timed [`Message`](message::Message)s, which a
//! [`RecordingFile`] keeps. [`Recording`] reads them back, and [`verify`](verify::verify) plays them
//! once more to prove that they were real.

mod about;
pub mod export;
mod file;
#[cfg(feature = "live")]
mod live;
pub mod message;
mod paint;
mod player;
mod read;
mod schemas;
#[cfg(test)]
mod tests;
pub mod verify;

pub use about::{About, AboutError, Source};
pub use file::{LAYOUT, RecordingFile, layout_beside};
#[cfg(feature = "live")]
pub use live::{Live, LiveError};
pub use player::{PlayError, Played, Player};
pub use read::{ReadError, Recorded, Recording, Sent};
