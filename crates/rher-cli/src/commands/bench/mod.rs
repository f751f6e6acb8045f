//! `rher bench`: the speed of this machine.

pub(super) mod env;
pub(super) mod update;
