//! The simulated tasks, against their contract, their physics and recordings of the real ones.

mod contract;
mod determinism;
mod mirror;
mod physics;
mod scripted;
mod support;
mod traces;
