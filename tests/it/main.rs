//! The `rher` program, tested from outside.

mod cli;
mod determinism;
mod resume;
mod support;
