//! What the same seed gives on every machine, as hashes, part by part.
//!
//! A hash is of bits: one number that differs in its last digit is another hash. The parts are in
//! the order in which a run depends on them, so that the first one that differs is to blame.
//!
//! ```
//! use rher_bits::{Part, Task, known, measure};
//!
//! let hash = measure(Task::PUSH, Part::Physics)?;
//! assert_eq!(hash, known::hash(Task::PUSH, Part::Physics).expect("push is one of the tasks"));
//! # Ok::<(), rher_bits::MeasureError>(())
//! ```
//!
//! The program of this crate prints them all. It needs no C, so that it can be built for other
//! machines, and run in emulators of these.

mod hash;
pub mod known;
mod measure;
mod part;

pub use hash::tensors;
pub use measure::{MeasureError, measure};
pub use part::Part;
pub use rher_envs::Task;
