//! Sweeps that several machines may share: what is to be trained, and who trains it now.

mod attempt;
mod claim;
mod plan;
mod unnamed;

pub use attempt::{AttemptError, Beat, End, Life, Seen, Worker, look};
pub use claim::{Claim, ClaimError, Guard, Lost, PATIENCE, Pulse};
pub use plan::{Cell, Plan, PlanError, PlanId, from_plan};
