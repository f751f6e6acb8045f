//! Recordings as datasets for those who learn from demonstrations.

mod columns;
mod dataset;
mod demonstration;
mod error;
mod lerobot;
mod minari;
mod stats;

pub use dataset::{Dataset, DatasetFormat};
pub use demonstration::Demonstration;
pub use error::ExportError;
pub use minari::DatasetId;
