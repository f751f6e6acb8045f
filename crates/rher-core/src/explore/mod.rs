//! Self-guided exploration: a learned simpler policy leads into the states from which the next
//! one can be learned.

mod curriculum;
mod explorer;
mod log;

pub use curriculum::Curriculum;
pub use explorer::{ActionSource, Explorer, Selection};
pub use log::{ActionLog, Decision};
