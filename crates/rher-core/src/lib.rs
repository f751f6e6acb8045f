//! Relay Hindsight Experience Replay for environments of your own.
//!
//! Modules in the order in which data flows through them: [`goal`] and [`env`] say what is asked
//! and what happens, [`episode`] and [`replay`] keep it, [`relabel`] replays it for every sub-task.

pub mod agent;
pub mod batch;
#[cfg(feature = "agent")]
pub mod checkpoint;
pub mod config;
pub mod env;
pub mod episode;
#[cfg(feature = "agent")]
pub mod evaluate;
#[cfg(feature = "agent")]
pub mod event;
pub mod explore;
#[cfg(feature = "agent")]
mod files;
pub mod goal;
pub mod input;
pub mod normalize;
pub mod relabel;
pub mod replay;
pub mod seed;
#[cfg(feature = "agent")]
pub mod train;
