//! The layout of observations, written once for their numbers, their width, their mirror image, what
//! they are when objects trade places, what they are called, and where positions are in them.

mod labels;
mod layout;
mod owners;
mod places;
mod sink;

pub(crate) use labels::Labels;
pub use layout::gripper_and_object;
pub(crate) use layout::{
    Numbers, Reflections, cue_and_object, gripper_alone, gripper_and_stack,
    gripper_and_three_objects, gripper_and_two_objects, gripper_handle_and_block, tip_and_place,
};
pub(crate) use owners::Owners;
pub use places::Places;
pub(crate) use places::Positions;
pub use sink::{Sink, Subject};
