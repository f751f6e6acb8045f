//! The tasks, one file each.

mod pick;
mod push;
mod reach;

pub use pick::Pick;
pub use push::Push;
pub use reach::Reach;

use crate::simulation::Layout;
use rand::{Rng, RngExt as _};
use rher_core::goal::Position;

/// Height of a block's centre once it has settled on the table, in metres.
const BLOCK_HEIGHT: f32 = 0.42489;

/// How far from the gripper objects and targets are drawn, along x and y, in metres.
const SPREAD: f32 = 0.15;

/// How near to the gripper no object starts, along the table, in metres.
const CLEARANCE: f32 = 0.1;

/// A block and its target anywhere on the table in front of the gripper.
fn draw_block_and_target(home: Position, rng: &mut impl Rng) -> Layout<1> {
    let object = loop {
        let object = draw_on_table(home, rng);
        if (object - home).xy().norm() >= CLEARANCE {
            break object;
        }
    };
    Layout { objects: [object], targets: [draw_on_table(home, rng)] }
}

/// A place for a block.
fn draw_on_table(home: Position, rng: &mut impl Rng) -> Position {
    let mut offset = || rng.random_range(-SPREAD..SPREAD);
    Position::new(home.x + offset(), home.y + offset(), BLOCK_HEIGHT)
}
