//! Runs as curves and as numbers.

mod chart;
mod curves;
mod figure;
mod file;
mod looks;
mod metrics;
mod published;
pub(crate) mod statistics;
mod success;
mod view;

pub(crate) use chart::{
    Axis, Dash, Intervals, Line, LinePanel, Panel, Row, Sheet, escaped, sample,
};
pub(crate) use curves::Curve;
pub(crate) use figure::{Figure, by_task};
pub(crate) use looks::Looks;
pub(crate) use metrics::quantities;
pub(crate) use view::{Clock, Measure, View, name};
