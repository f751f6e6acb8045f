//! What the tasks with blocks on the table share.

use crate::sim::{Body, Fingers, Motion, World};
use crate::simulation::MIDDLE;
use rand::{Rng, RngExt as _};
use rher_core::goal::Position;
use std::array;

/// Where the gripper starts with its fingers pressed on the table, as in `FetchPush`.
pub(super) const ON_TABLE: Position = Position::new(1.363, MIDDLE, 0.416);

/// Where the gripper starts in the air, its fingers closed, as in `FetchPickAndPlace`.
pub(super) const IN_THE_AIR: Position = Position::new(1.3419, MIDDLE, 0.5347);

/// Height of a block's centre once it has settled on the table, in metres.
const BLOCK_HEIGHT: f32 = 0.42489;

/// How near to the gripper no block starts, along the table, in metres.
const CLEARANCE: f32 = 0.1;

/// Blocks on the table, in relay order.
pub(super) struct Blocks<const N: usize>([Body; N]);

impl<const N: usize> Blocks<N> {
    /// A table with blocks, and a gripper at `home`.
    pub(super) fn build(fingers: Fingers, home: Position) -> (Self, World) {
        let (world, blocks) = World::new(fingers, home, |scenery| {
            scenery.table();
            array::from_fn(|_| scenery.block())
        });
        (Self(blocks), world)
    }

    /// Puts the blocks of a fresh world in their places.
    pub(super) fn place(&self, positions: &[Position; N], world: &mut World) {
        for (block, position) in self.0.iter().zip(positions) {
            world.place(*block, *position);
        }
    }

    /// Where the blocks are and how they move.
    pub(super) fn motions(&self, world: &World) -> [Motion; N] {
        self.0.map(|block| world.motion(block))
    }

    /// Where the blocks are.
    pub(super) fn positions(&self, world: &World) -> [Position; N] {
        self.motions(world).map(|motion| motion.position)
    }
}

/// Draws places for blocks, up to `spread` metres from `home` along x and y, until `fit` accepts
/// them all.
pub(super) fn draw_places<const N: usize>(
    home: Position,
    spread: f32,
    rng: &mut impl Rng,
    fit: impl Fn(&[Position; N]) -> bool,
) -> [Position; N] {
    loop {
        let places = array::from_fn(|_| {
            let mut offset = || rng.random_range(-spread..spread);
            Position::new(home.x + offset(), home.y + offset(), BLOCK_HEIGHT)
        });
        if fit(&places) {
            return places;
        }
    }
}

/// Whether none of the places is so near to `home` that a block there could touch the gripper.
pub(super) fn are_clear_of(home: Position, places: &[Position]) -> bool {
    places.iter().all(|place| (place - home).xy().norm() >= CLEARANCE)
}
