//! The `rher` program, tested from outside.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod cli;
mod determinism;
mod learning;
mod options;
mod reproduce;
mod resume;
mod stats;
mod support;
mod sweep;
