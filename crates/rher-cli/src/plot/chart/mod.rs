//! Line charts: panels of curves, laid out as lines, areas and words that two writers draw.

mod drawing;
mod marks;
mod panel;
mod raster;
mod svg;

pub(crate) use drawing::Drawing;
pub(crate) use marks::Ink;
pub(crate) use panel::{Axis, Line, Panel};
pub(crate) use svg::escaped;
