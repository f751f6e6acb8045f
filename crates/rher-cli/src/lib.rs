//! The program `rher`: train, evaluate and measure relay hindsight policies.
//!
//! It is a library so that the Python package can have the same command, and so that a program of
//! your own can have it for tasks of your own: [`Program`] is all of it.

mod cells;
mod children;
mod chosen;
mod cli;
mod commands;
mod errors;
mod exit_code;
mod expected;
mod failure;
mod film;
mod flops;
mod host;
mod jobs;
mod numbers;
mod observe;
mod output;
mod plot;
mod printer;
mod program;
mod published;
mod running;
mod shell;
mod shipped;
mod surroundings;
mod tables;
mod tips;
mod trained;
mod values;

pub use program::Program;
