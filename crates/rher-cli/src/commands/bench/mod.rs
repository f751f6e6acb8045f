//! `rher bench`: the speed of this machine.

pub(super) mod env;
mod flops;
pub(super) mod update;
