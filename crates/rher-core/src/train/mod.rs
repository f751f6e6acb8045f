//! Training: the loop, and the run on disk.

pub mod checkpoint;
mod error;
pub mod memory;
mod play;
mod rows;
mod state;
mod tally;
mod trainer;

pub use error::{Finish, TrainError};
pub use trainer::Trainer;
