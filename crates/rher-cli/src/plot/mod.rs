//! Runs as curves and as numbers.

mod chart;
mod curves;
mod figure;
mod published;
pub(crate) mod statistics;

pub(crate) use chart::escaped;
pub(crate) use figure::{Clock, Figure, Measure};
