//! Training: the loop, and the run on disk.

pub mod checkpoint;
mod error;
mod identity;
mod in_order;
pub mod memory;
mod play;
mod pretrained;
mod rows;
mod state;
mod tally;
mod trainer;

pub use error::{Finish, TrainError};
pub use identity::run_id;
pub use pretrained::{Pretrained, PretrainedError, Unfit};
pub use trainer::Trainer;
