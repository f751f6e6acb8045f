//! The simulated tasks, against their contract, their physics and recordings of the real ones.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![expect(clippy::print_stdout, reason = "the figures in docs/, which `--nocapture` shows")]

mod beginnings;
mod blocks;
mod cameras;
mod contract;
mod cue_push;
mod determinism;
mod drawer;
mod edges;
mod exchange;
mod hashes;
mod insert;
mod mirror;
mod names;
mod obstacle_push;
mod options;
mod physics;
mod pictures;
mod places;
mod pool;
mod scripted;
mod slide;
mod sliding;
mod soak;
mod strokes;
mod support;
mod things;
mod traces;
