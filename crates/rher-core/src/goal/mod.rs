//! What is asked for, what was reached, and whether the two agree.
//!
//! Everything here is a pure function of positions and their tails: no IO, no randomness, no tensors.
//! The order of the files is the order of the method: a [`Scene`] is cut into [`Stage`]s, each
//! stage sees its own [`EncodedGoal`], and [`EncodedGoal::reward`] judges what came of it.

mod encoding;
mod metric;
mod position;
mod reward;
mod scene;
mod stage;
mod tail;
mod tolerances;

pub use encoding::{EncodedGoal, Slot};
pub use metric::Metric;
pub use position::Position;
pub(crate) use position::unit;
pub use reward::{FAILURE, SUCCESS};
pub use scene::{Achieved, Desired, LaterObjects, Scene};
pub use stage::{Leg, Stage};
pub(crate) use tail::{TAIL_INPUTS, Tail};
pub use tail::{TAIL_NUMBERS, TailError, TailPart, TailSpec, Tails};
pub use tolerances::Tolerances;
