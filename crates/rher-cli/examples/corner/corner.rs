use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;
use rher_envs::{Body, Fingers, Layout, Scenario, Sink, World, gripper_and_object};

/// Where the gripper starts, its fingers pressed on the table.
const HOME: Position = Position::new(1.363, 0.7491, 0.416);

/// Height of a block's center on the table, in meters.
const HEIGHT: f32 = 0.425;

/// Push a block into a corner.
pub(crate) struct Corner {
    block: Body,
}

impl Scenario<1> for Corner {
    const NAME: &'static str = "corner";
    // The scene is the same in front of the hand as behind it: a second mirror to learn from.
    const FRONT_LIKE_BACK: bool = true;

    // The scene: a table of the Fetch environments, a block, and fingers that stay closed.
    fn build() -> (Self, World) {
        let (world, block) = World::new(Fingers::Locked, HOME, |scenery| {
            scenery.table();
            scenery.block()
        });
        (Self { block }, world)
    }

    // How an episode begins: positions of the objects, and their targets.
    fn draw(rng: &mut ChaCha8Rng) -> Layout<1> {
        let mut side = || if rng.random() { 0.12 } else { -0.12 };
        let corner = Position::new(HOME.x + side(), HOME.y + side(), HEIGHT);
        let block = Position::new(HOME.x + side(), HOME.y, HEIGHT);
        Layout::new([block], [corner])
    }

    fn place(&self, layout: &Layout<1>, world: &mut World) {
        world.place(self.block, layout.objects[0], layout.turns[0]);
    }

    // The positions that goals and rewards use.
    fn objects(&self, _: &Layout<1>, world: &World) -> [Position; 1] {
        [world.motion(self.block).position]
    }

    // What the agent observes: here the 25 numbers of `FetchPush`. `Sink` takes positions, vectors,
    // rotations and fingers, each with its name, and so knows the mirror image of each number, and
    // where a run on another task finds it.
    // (For several interchangeable objects, see `Scenario::ALIKE` and `Sink::about`.)
    fn observe(&self, _: &Layout<1>, world: &World, out: &mut impl Sink) {
        gripper_and_object(&world.grip(), &world.motion(self.block), out);
    }
}
