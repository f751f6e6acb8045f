//! Episodes in a few words.

use nalgebra::Vector3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::Start;
use rher_core::goal::{Achieved, Desired, EncodedGoal, Position, Scene};
use rher_envs::tasks::{Pick, Push};
use rher_envs::{ACTION_WIDTH, Layout, OptionValue, Options, Simulated, Simulation, Task};

/// Half the edge of a block, in meters.
pub(crate) const HALF_BLOCK: f32 = 0.025;

/// Height of a block's center at rest on the table, in meters.
pub(crate) const BLOCK_HEIGHT: f32 = 0.42489;

/// From the grip center down to the fingertips, in meters.
pub(crate) const FINGERTIP: f32 = 0.0195;

/// An environment and where its objects stand.
pub(crate) struct Stand<E, const N: usize = 1> {
    pub(crate) env: E,
    pub(crate) observation: Vec<f32>,
    pub(crate) scene: Scene<N>,
}

pub(crate) fn push() -> Stand<Simulation<Push, 1>> {
    Stand::new(Simulation::new())
}

pub(crate) fn pick() -> Stand<Simulation<Pick, 1>> {
    Stand::new(Simulation::new())
}

/// Episodes of 100 whose goal is met at the last step.
pub(crate) fn solved<E, C>(stand: fn() -> Stand<E>, controller: impl Fn() -> C) -> usize
where
    E: Simulated<1>,
    C: FnMut(&Stand<E>, Position) -> [f32; ACTION_WIDTH],
{
    let mut stand = stand();
    let solved = (0..100)
        .filter(|seed| {
            let desired = stand.reset(*seed);
            let mut act = controller();
            for _ in 0..stand.env.spec().episode_steps {
                let action = act(&stand, desired.objects()[0]);
                stand.step(action);
            }
            is_met(&stand.env, Achieved(stand.scene), &desired)
        })
        .count();
    println!("{}: {solved} of 100 solved", stand.env.spec().name);
    solved
}

impl<E: Simulated<N>, const N: usize> Stand<E, N> {
    pub(crate) fn new(env: E) -> Self {
        let observation = vec![0.0; env.spec().obs_dim];
        let mut stand = Self { env, observation, scene: nowhere() };
        stand.reset(0);
        stand
    }

    pub(crate) fn reset(&mut self, seed: u64) -> Desired<N> {
        let start = self.env.reset(seed, &mut self.observation).unwrap();
        self.begin(start)
    }

    /// Puts the objects somewhere.
    pub(crate) fn arrange(&mut self, objects: [Position; N]) {
        let layout = Layout::new(objects, objects);
        let start = self.env.arrange(layout, &mut self.observation).unwrap();
        self.begin(start);
    }

    fn begin(&mut self, start: Start<N>) -> Desired<N> {
        self.scene = start.achieved.0;
        start.desired
    }

    pub(crate) fn step(&mut self, action: [f32; ACTION_WIDTH]) {
        let action = &action[..self.env.spec().action_dim];
        self.scene = self.env.step(action, &mut self.observation).unwrap().0;
    }

    pub(crate) fn repeat(&mut self, steps: usize, action: [f32; ACTION_WIDTH]) {
        for _ in 0..steps {
            self.step(action);
        }
    }

    /// Moves the hand to a place, the fingers doing `fingers`; gives up after 40 steps.
    pub(crate) fn go_to(&mut self, place: Position, fingers: f32) {
        for _ in 0..40 {
            if (place - self.scene.gripper).norm() < 0.002 {
                break;
            }
            self.step(towards(place, self.scene.gripper, fingers));
        }
    }
}

impl<E: Simulated<1>> Stand<E> {
    /// Puts the block at a place on the table.
    pub(crate) fn put(&mut self, x: f32, y: f32) {
        self.arrange([Position::new(x, y, BLOCK_HEIGHT)]);
    }

    pub(crate) fn block(&self) -> Position {
        self.scene.objects[0]
    }

    /// From the hand to the block.
    pub(crate) fn held(&self) -> Vector3<f32> {
        self.scene.objects[0] - self.scene.gripper
    }
}

/// The action that brings the hand from `here` to `place`, at full speed if it is far.
pub(crate) fn towards(place: Position, here: Position, fingers: f32) -> [f32; ACTION_WIDTH] {
    let [x, y, z]: [f32; 3] = ((place - here) * 20.0).into();
    [x, y, z, fingers]
}

/// Along the table.
pub(crate) fn flat(v: Vector3<f32>) -> Vector3<f32> {
    Vector3::new(v.x, v.y, 0.0)
}

/// The same place at another height.
pub(crate) fn at_height(p: Position, z: f32) -> Position {
    Position::new(p.x, p.y, z)
}

/// Whether the last sub-task is met.
pub(crate) fn is_met<const N: usize>(
    env: &impl Simulated<N>,
    achieved: Achieved<N>,
    desired: &Desired<N>,
) -> bool {
    let last = env.spec().last_stage();
    EncodedGoal::new(last, &achieved, desired).is_met(&achieved, &env.spec().tolerances)
}

pub(crate) fn random_action(rng: &mut ChaCha8Rng) -> [f32; ACTION_WIDTH] {
    std::array::from_fn(|_| rng.random_range(-1.0..1.0))
}

/// The task's options, so that everything is seen where it is.
pub(crate) fn seen_clearly(task: Task) -> Options {
    let mut options = Options::of(task.options());
    for (name, value) in &mut options.task.0 {
        if name == "noise" || name == "delay" {
            *value = OptionValue::Count(0);
        }
    }
    options
}

fn nowhere<const N: usize>() -> Scene<N> {
    Scene::new(Position::origin(), [Position::origin(); N])
}
