//! Charts: panels of curves and of estimates, laid out as marks that two writers draw.

mod axis;
mod frame;
mod intervals;
mod lines;
mod marks;
mod raster;
mod sheet;
mod svg;

pub(crate) use axis::Axis;
pub(crate) use intervals::{Intervals, Row};
pub(crate) use lines::{Line, LinePanel, Look};
pub(crate) use marks::{Dash, Ink};
pub(crate) use sheet::{Drawing, Panel, Sheet};
pub(crate) use svg::{escaped, sample};
