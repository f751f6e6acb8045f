//! Where positions are in an observation.

use crate::support::{random_action, seen_clearly};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::Env as _;
use rher_core::goal::{Achieved, Position};
use rher_envs::{
    Body, EnvVisitor, Fingers, Layout, Places, Scenario, Simulated, Simulation, Sink, Subject,
    Task, World,
};

#[test]
fn positions_are_where_the_layout_says() {
    for task in Task::ALL {
        task.visit_with(&seen_clearly(*task), Watch(*task)).unwrap();
    }
}

struct Watch(Task);

impl EnvVisitor for Watch {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let task = self.0;
        let mut env = build();
        let Places { gripper, objects } = env.places();
        // The only goal of `reach` is a place in the air, which is not observed.
        assert_eq!(objects.iter().all(Option::is_some), task != Task::REACH, "{task}");
        let mut observation = vec![0.0; env.spec().obs_dim];
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        for seed in 0..3 {
            let mut achieved = env.reset(seed, &mut observation).unwrap().achieved;
            for _ in 0..10 {
                let Achieved(scene) = achieved;
                let at = |place: usize| Position::from_slice(&observation[place..place + 3]);
                assert_eq!(gripper.map(at), Some(scene.gripper), "{task}");
                for (place, object) in objects.iter().zip(scene.objects) {
                    assert_eq!(place.map_or(object, at), object, "{task}");
                }
                let action = &random_action(&mut rng)[..env.spec().action_dim];
                achieved = env.step(action, &mut observation).unwrap();
            }
        }
    }
}

/// Two blocks that are alike; the observation says as much about which is which as `SAYS` does.
struct Twins<const SAYS: usize>([Body; 2]);

const NOTHING: usize = 0;
const ONE: usize = 1;
const BOTH: usize = 2;

impl<const SAYS: usize> Scenario<2> for Twins<SAYS> {
    const NAME: &'static str = "twins";
    const ALIKE: bool = true;

    fn build() -> (Self, World) {
        let home = Position::new(1.363, 0.7491, 0.416);
        let (world, blocks) = World::new(Fingers::Locked, home, |scenery| {
            scenery.table();
            [scenery.block(), scenery.block()]
        });
        (Self(blocks), world)
    }

    fn draw(_: &mut ChaCha8Rng) -> Layout<2> {
        let at = |y| Position::new(1.3, y, 0.425);
        Layout::new([at(0.6), at(0.9)], [at(0.7), at(0.8)])
    }

    fn place(&self, layout: &Layout<2>, world: &mut World) {
        for (body, position) in self.0.iter().zip(layout.objects) {
            world.place(*body, position, 0.0);
        }
    }

    fn objects(&self, _: &Layout<2>, world: &World) -> [Position; 2] {
        self.0.map(|body| world.motion(body).position)
    }

    fn observe(&self, layout: &Layout<2>, world: &World, out: &mut impl Sink) {
        out.gripper(world.grip().position);
        for (index, position) in self.objects(layout, world).into_iter().enumerate() {
            if index < SAYS {
                out.about(Subject::Object(index));
            }
            out.object(index, position);
        }
    }
}

#[test]
fn objects_that_are_alike_are_exchanged_where_the_observation_tells_them_apart() {
    let env = Simulation::<Twins<BOTH>, 2>::new();
    let [exchange] = env.spec().permutations.as_slice() else { panic!("expected one exchange") };
    let from: Vec<usize> = exchange.observation.iter().map(|index| index.from).collect();
    assert_eq!(from, [0, 1, 2, 6, 7, 8, 3, 4, 5]);
    assert_eq!(env.places(), Places { gripper: Some(0), objects: [Some(3), Some(6)] });
}

#[test]
#[should_panic(expected = "task `twins`: its objects are alike")]
fn objects_that_are_alike_and_not_told_apart_are_refused() {
    let _ = Simulation::<Twins<NOTHING>, 2>::new();
}

#[test]
#[should_panic(expected = "call `Sink::about` before each part")]
fn one_object_told_apart_is_not_enough() {
    let _ = Simulation::<Twins<ONE>, 2>::new();
}

/// Drives a hand as far as it goes along an axis.
struct Drive([f32; 4]);

impl EnvVisitor for Drive {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let Self(action) = self;
        let mut env = build();
        let width = env.spec().action_dim;
        let mut observation = vec![0.0; env.spec().obs_dim];
        let mut at = env.reset(1, &mut observation).unwrap().achieved.0.gripper;
        assert!(env.can_reach(&at));
        for _ in 0..200 {
            at = env.step(&action[..width], &mut observation).unwrap().0.gripper;
        }
        let [x, y, ..] = action;
        let further = |meters: f32| at + rher_core::nalgebra::Vector3::new(x, y, 0.0) * meters;
        let name = &env.spec().name;
        assert!(env.can_reach(&further(-0.05)), "{name}: {at}");
        assert!(!env.can_reach(&further(0.15)), "{name}: {at}");
    }
}

#[test]
fn the_hand_gets_as_far_as_it_can_reach() {
    for task in [Task::PICK, Task::SLIDE, Task::CUE_PUSH] {
        for action in [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0]] {
            task.visit(Drive(action));
        }
    }
}
