//! Tests of environments of your own, and the smallest environment to try things on.

mod carry;
mod check;

pub use carry::Carry;
pub use check::{CheckError, Checked, check_env};
