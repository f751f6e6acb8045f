//! Many environments, stepped together.

mod record;
mod step;

pub use record::PoolRecord;
pub use step::{AutoReset, Frames, Pool, PoolError};
