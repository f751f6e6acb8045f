//! `ObstaclePush`: push a block to a place on the table, round an obstacle.

use super::blocks::{ON_TABLE, are_clear_of, draw_places};
use crate::layout::Layout;
use crate::observation::{Sink, Subject, gripper_and_object};
use crate::options::{TaskOption, TaskOptions};
use crate::sim::{BLOCK_EDGE, Body, Fingers, OBSTACLE_HALF, World};
use crate::simulation::Scenario;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// How far from the gripper block and target are drawn, along x and y, in meters.
const SPREAD: f32 = 0.15;

/// Push a block to a place on the table, round an obstacle.
///
/// `push` with a box that nothing moves halfway between where hand and block start, as in the
/// authors' `FetchObsPush`; three numbers more in the observation say where, seen from the hand,
/// which is easier to learn from than the authors' place in the world. Here the box is in neither of
/// them: such places are drawn again.
pub struct ObstaclePush {
    block: Body,
    obstacle: Body,
    shows_obstacle: bool,
}

const OBSERVE_OBSTACLE: TaskOption = TaskOption::flag(
    "observe_obstacle",
    true,
    "Whether the observation includes the position of the obstacle relative to the hand. If false, \
     those three dimensions are 0.",
);

impl Scenario<1> for ObstaclePush {
    const NAME: &'static str = "obstacle-push";
    const VERBS: [&'static str; 1] = ["push"];
    const FRONT_LIKE_BACK: bool = true;
    const OPTIONS: &'static [TaskOption] = &[OBSERVE_OBSTACLE];
    const RECIPE: Option<&'static str> = Some(include_str!("obstacle-push.toml"));

    fn build() -> (Self, World) {
        let (world, (block, obstacle)) = World::new(Fingers::Locked, ON_TABLE, |scenery| {
            scenery.table();
            (scenery.block(), scenery.obstacle())
        });
        (Self { block, obstacle, shows_obstacle: true }, world)
    }

    fn configure(&mut self, options: &TaskOptions, _: &mut World) {
        self.shows_obstacle = options.flag(&OBSERVE_OBSTACLE);
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        Layout::new(
            draw_places(ON_TABLE, SPREAD, rng, |places| {
                are_clear_of(ON_TABLE, places) && leaves_room(places[0])
            }),
            draw_places(ON_TABLE, SPREAD, rng, |_| true),
        )
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        world.place(self.block, layout.objects[0], layout.turns[0]);
        world.place(self.obstacle, obstacle(layout.objects[0]), 0.0);
    }

    fn objects(&self, _: &Layout<1>, world: &World) -> [Position; 1] {
        [world.motion(self.block).position]
    }

    fn observe(&self, layout: &Layout<1>, world: &World, out: &mut impl Sink) {
        gripper_and_object(&world.grip(), &world.motion(self.block), out);
        out.about(Subject::Scenery("obstacle"));
        if self.shows_obstacle {
            let from_gripper = obstacle(layout.objects[0]) - world.grip().position;
            out.vector("from_gripper", from_gripper);
        } else {
            out.vector("hidden", Vector3::zeros());
        }
    }
}

/// Where the obstacle stands for a block that starts at `block`.
fn obstacle(block: Position) -> Position {
    let halfway = nalgebra::center(&ON_TABLE, &block);
    Position::new(halfway.x, halfway.y, 0.4 + OBSTACLE_HALF[2])
}

/// Whether the obstacle is neither in the hand nor in the block.
fn leaves_room(block: Position) -> bool {
    let from_block = obstacle(block) - block;
    let [x, y, _] = OBSTACLE_HALF.map(|half| half + BLOCK_EDGE / 2.0);
    from_block.x.abs() > x || from_block.y.abs() > y
}
