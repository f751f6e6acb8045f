//! Episodes as pictures.

mod animation;
mod filmed;
mod pictures;

pub(crate) use animation::Animation;
pub(crate) use filmed::{Film, SIZE};
pub(crate) use pictures::Pictures;
