//! The physics: one Rapier world around one gripper.
//!
//! Rapier and its math stay inside this module; what leaves it speaks nalgebra.

mod body;
mod cabinet;
mod camera;
mod convert;
mod edges;
mod gripper;
mod late;
mod look;
mod material;
mod scenery;
mod things;
mod variation;
mod world;

pub use body::{Body, Motion};
pub(crate) use cabinet::Cabinet;
pub(crate) use camera::LONGEST_DELAY;
pub(crate) use gripper::CUE_RADIUS;
pub use gripper::{Fingers, Grip};
pub use scenery::Scenery;
pub(crate) use scenery::{
    BLOCK_EDGE, CYLINDER_HEIGHT, CYLINDER_RADIUS, OBSTACLE_HALF, PLATE_HEIGHT, PUCK_HEIGHT,
};
pub(crate) use world::State;
pub use world::{DETECTIONS_AND_SOLVER_SUBSTEPS, RAPIER_VERSION, STEP_SECONDS, World};
