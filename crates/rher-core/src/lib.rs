//! Relay Hindsight Experience Replay for environments of your own.
//!
//! Modules in the order in which data flows through them: [`goal`] and [`env`] say what is asked
//! and what happens.

#[cfg(feature = "agent")]
pub mod agent;
pub mod batch;
pub mod env;
pub mod goal;
