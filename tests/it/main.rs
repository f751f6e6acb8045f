//! The `rher` program, tested from outside.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod architecture;
mod bits;
mod cli;
mod datasets;
mod determinism;
mod doctor;
mod figures;
mod films;
mod identity;
mod learning;
#[cfg(feature = "live")]
mod live;
mod models;
mod newcomers;
mod options;
mod own_task;
mod pages;
mod plans;
mod pretrained;
mod python;
mod recordings;
mod reports;
mod reproduce;
mod resume;
mod site;
mod stats;
mod support;
mod sweep;
mod tensorboard;
#[path = "../venv.rs"]
mod venv;
mod versions;
