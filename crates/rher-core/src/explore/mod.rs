//! Self-guided exploration: a learned simpler policy leads into the states from which the next
//! one can be learned.

mod curriculum;
mod guide;
mod script;

pub use curriculum::Curriculum;
pub use guide::{Choice, Decider, Guide};
pub use script::{Decision, Script};
