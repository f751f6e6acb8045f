//! What the tasks with blocks on the table share.

use crate::layout::Layout;
use crate::sim::{BLOCK_EDGE, Body, Fingers, Motion, World};
use crate::simulation::MIDDLE;
use rand::{Rng, RngExt as _};
use rher_core::goal::Position;
use std::array;

/// Where the gripper starts with its fingers pressed on the table, as in `FetchPush`.
pub(super) const ON_TABLE: Position = Position::new(1.363, MIDDLE, 0.416);

/// Where the gripper starts in the air, its fingers closed, as in `FetchPickAndPlace`.
pub(super) const IN_THE_AIR: Position = Position::new(1.3419, MIDDLE, 0.5347);

/// Height of a block's center once it has settled on the table, in meters.
const BLOCK_HEIGHT: f32 = 0.42489;

/// How near to the gripper no block starts, along the table, in meters.
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
    pub(super) fn place(&self, layout: &Layout<N>, world: &mut World) {
        for (block, (position, turn)) in self.0.iter().zip(layout.objects.iter().zip(layout.turns))
        {
            world.place(*block, *position, turn);
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

/// Draws places for blocks, up to `spread` meters from `home` along x and y, until `fit` accepts
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

/// Places for blocks on top of each other, the lowest at `foot`.
pub(super) fn stacked_on<const N: usize>(foot: Position) -> [Position; N] {
    let mut next = foot;
    array::from_fn(|_| {
        let place = next;
        next.z += BLOCK_EDGE;
        place
    })
}

/// Whether none of the places is so near to `home` that a block there could touch the gripper.
pub(super) fn are_clear_of(home: Position, places: &[Position]) -> bool {
    places.iter().all(|place| (place - home).xy().norm() >= CLEARANCE)
}

/// Whether every two places are at least `distance` meters from each other.
pub(super) fn are_apart(distance: f32, places: &[Position]) -> bool {
    every_two(places).all(|(a, b)| (a - b).xy().norm() >= distance)
}

/// Whether blocks in these places would be partly inside one another.
pub(super) fn overlap(places: &[Position]) -> bool {
    every_two(places).any(|(a, b)| (a - b).xy().amax() < BLOCK_EDGE)
}

/// Every pair of two places.
fn every_two(places: &[Position]) -> impl Iterator<Item = (&Position, &Position)> {
    places.iter().enumerate().flat_map(|(i, a)| places[..i].iter().map(move |b| (a, b)))
}
