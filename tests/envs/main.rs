//! The simulated tasks, against their contract, their physics and recordings of the real ones.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![expect(clippy::print_stdout, reason = "the figures in docs/, which `--nocapture` shows")]

mod blocks;
mod contract;
mod determinism;
mod drawer;
mod insert;
mod mirror;
mod obstacle_push;
mod physics;
mod scripted;
mod slide;
mod support;
mod traces;
