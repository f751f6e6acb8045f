//! `CuePush`: push a cylinder to a place on the table with a cue, as on the real robot.

use crate::layout::Layout;
use crate::observation::{Sink, cue_and_object};
use crate::options::{TaskOption, TaskOptions};
use crate::sim::{
    Body, CUE_RADIUS, CYLINDER_HEIGHT, CYLINDER_RADIUS, Fingers, LONGEST_DELAY, World,
};
use crate::simulation::{MIDDLE, Scenario};
use rand::{Rng, RngExt as _};
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;

/// Height of the table, in meters.
const TABLE: f32 = 0.4;

/// The middle of the workspace, on the table.
const MIDDLE_OF_WORKSPACE: Position = Position::new(1.3, MIDDLE, TABLE);

/// Half of the workspace's edges, along x and y, in meters.
const WORKSPACE_HALF: [f32; 2] = [0.045, 0.07];

/// How far an action of 1 asks the cue to move, in meters.
const PER_STEP: f32 = 0.03;

/// How far above the table the cue's tip is at least, in meters.
const LOWEST: f32 = 0.005;

/// The same at most.
const HIGHEST: f32 = 0.07;

/// The same when an episode begins.
const HOME: f32 = 0.05;

/// How far from its target the cylinder starts at least, in meters: twice the tolerance.
const APART: f32 = 0.04;

const NOISE: TaskOption = TaskOption::number(
    "noise",
    0.001,
    0.02,
    "Standard deviation in meters of the camera noise along each axis.",
);

const DELAY: TaskOption = TaskOption::count(
    "delay",
    1,
    LONGEST_DELAY as u32,
    "Delay of the camera in environment steps.",
);

/// Push a cylinder to a place on the table with a cue.
///
/// The paper's `CuePush`, which was a real robot: size of cylinder and workspace, tolerance and
/// length of episodes are the paper's, the rest is chosen. Cue and cylinder are told by a camera,
/// with noise and late, and so are goals and rewards.
pub struct CuePush {
    cylinder: Body,
}

impl Scenario<1> for CuePush {
    const NAME: &'static str = "cue-push";
    const VERBS: [&'static str; 1] = ["push"];
    const OBJECTS: [&'static str; 1] = ["cylinder"];
    const FRONT_LIKE_BACK: bool = true;
    const ACTION_WIDTH: usize = 3;
    const EPISODE_STEPS: usize = 20;
    const TOLERANCE: f32 = 0.02;
    /// Touching it is 3 cm away from its middle.
    const REACH_TOLERANCE: f32 = 0.04;
    const OPTIONS: &'static [TaskOption] = &[NOISE, DELAY];
    const RECIPE: Option<&'static str> = Some(include_str!("cue-push.toml"));

    fn build() -> (Self, World) {
        let home = above_middle(0.0, 0.0, HOME);
        let (world, cylinder) = World::new(Fingers::Cue, home, |scenery| {
            let [x, y] = WORKSPACE_HALF;
            scenery.slow_hand(PER_STEP);
            scenery.limit_hand(above_middle(-x, -y, LOWEST), above_middle(x, y, HIGHEST));
            scenery.wooden_table();
            scenery.wooden_cylinder()
        });
        (Self { cylinder }, world)
    }

    fn configure(&mut self, options: &TaskOptions, world: &mut World) {
        world.watch(options.number(&NOISE), options.number(&DELAY) as usize);
    }

    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        loop {
            // The cue fits between the cylinder and the edges of the workspace at first, and the
            // cylinder in the workspace at last.
            let start = draw_within(CYLINDER_RADIUS + CUE_RADIUS, rng);
            let target = draw_within(CYLINDER_RADIUS, rng);
            if nalgebra::distance(&start, &target) >= APART {
                return Layout::new([start], [target]);
            }
        }
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        world.place(self.cylinder, layout.objects[0], layout.turns[0]);
    }

    fn objects(&self, _: &Layout<1>, world: &World) -> [Position; 1] {
        [world.motion(self.cylinder).position]
    }

    fn observe(&self, _: &Layout<1>, world: &World, out: &mut impl Sink) {
        cue_and_object(&world.grip(), &world.motion(self.cylinder), world.chosen(), out);
    }
}

/// A place above the middle of the workspace, or beside it.
fn above_middle(x: f32, y: f32, height: f32) -> Position {
    let Position { coords: middle } = MIDDLE_OF_WORKSPACE;
    Position::new(middle.x + x, middle.y + y, middle.z + height)
}

/// A place for the cylinder, at least `margin` meters from the edges of the workspace.
fn draw_within(margin: f32, rng: &mut impl Rng) -> Position {
    let [x, y] = WORKSPACE_HALF.map(|half| rng.random_range(margin - half..half - margin));
    above_middle(x, y, CYLINDER_HEIGHT / 2.0)
}
