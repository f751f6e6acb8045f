//! `DrawerBox`: pull a drawer open, take a block out of it and put it on top of the cabinet.

use crate::layout::Layout;
use crate::observation::{Sink, gripper_handle_and_block};
use crate::sim::{Body, Cabinet, Fingers, World};
use crate::simulation::{MIDDLE, Scenario};
use nalgebra::Vector3;
use rand::{Rng, RngExt as _};
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Where the gripper starts, its fingers closed.
const HOME: Position = Position::new(1.3419, MIDDLE, 0.6347);

/// Where the robot stands, from where it stands in `FetchPush`.
const HIGHER: Vector3<f32> = Vector3::new(0.0, 0.0, 0.15);

/// Height of the handle, in meters.
const HANDLE_HEIGHT: f32 = 0.45;

/// Height of the block's center once it has settled in the drawer, in meters.
const BLOCK_HEIGHT: f32 = 0.4199;

/// Height that is asked of the block on top of the cabinet, in meters.
const TOP_HEIGHT: f32 = 0.51;

/// Pull a drawer open, take a block out of it and put it on top of the cabinet.
///
/// The paper's `DrawerBox`, with the ranges and the observation of the authors' environment. The
/// first object is the middle of the handle's bow, the second the block. An episode begins with the
/// drawer closed: where the handle is says where the cabinet is.
pub struct DrawerBox {
    cabinet: Cabinet,
    block: Body,
}

impl Scenario<2> for DrawerBox {
    const NAME: &'static str = "drawer-box";
    const VERBS: [&'static str; 2] = ["open", "place"];
    const OBJECTS: [&'static str; 2] = ["handle", "block"];
    const EPISODE_STEPS: usize = 60;
    const RECIPE: Option<&'static str> = Some(include_str!("drawer-box.toml"));

    fn build() -> (Self, World) {
        let (world, (cabinet, block)) = World::new(Fingers::Free, HOME, |scenery| {
            scenery.move_robot(HIGHER);
            scenery.keep_hand_above(HANDLE_HEIGHT);
            scenery.cabinet_table();
            (scenery.cabinet(), scenery.sluggish_block())
        });
        (Self { cabinet, block }, world)
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<2> {
        let handle = Position::new(
            rng.random_range(1.276..1.286),
            rng.random_range(0.77..0.78),
            HANDLE_HEIGHT,
        );
        let block = beside(handle, 0.1 + centered(0.02, rng), centered(0.02, rng), BLOCK_HEIGHT);
        let open = handle - Vector3::x() * (0.15 + rng.random_range(0.0..0.03));
        let top =
            beside(handle, 0.1 + rng.random_range(-0.03..0.1), centered(0.1, rng), TOP_HEIGHT);
        Layout::new([handle, block], [open, top])
    }

    fn place(&self, layout: &Layout<2>, world: &mut World) {
        let [handle, block] = layout.objects;
        self.cabinet.place(handle, 0.0, world);
        world.place(self.block, block, layout.turns[1]);
    }

    fn objects(&self, _: &Layout<2>, world: &World) -> [Position; 2] {
        [self.cabinet.handle(world).position, world.motion(self.block).position]
    }

    fn observe(&self, _: &Layout<2>, world: &World, out: &mut impl Sink) {
        let handle = self.cabinet.handle(world);
        gripper_handle_and_block(&world.grip(), &handle, &world.motion(self.block), out);
    }
}

/// A place at another height, meters further along x and y.
fn beside(place: Position, x: f32, y: f32, height: f32) -> Position {
    Position::new(place.x + x, place.y + y, height)
}

/// At most `spread` from 0.
fn centered(spread: f32, rng: &mut impl Rng) -> f32 {
    rng.random_range(-spread..spread)
}
