//! Relay Hindsight Experience Replay for environments of your own.
//!
//! Modules in the order in which data flows through them: [`goal`] and [`env`] say what is asked
//! and what happens.

#[cfg(feature = "agent")]
pub mod agent;
pub mod batch;
#[cfg(feature = "agent")]
pub mod config;
pub mod env;
#[cfg(feature = "agent")]
pub mod event;
pub mod goal;
pub mod seed;
