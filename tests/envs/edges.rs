//! Edges that are as if they were rounded keep a hand out all the same.

use crate::support::{FINGERTIP, Stand, at_height, random_action};
use nalgebra::Vector3;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;
use rher_envs::tasks::{Drawer, Insert};
use rher_envs::thing::{Form, Thing};
use rher_envs::{Simulated, Simulation};

/// How deep a hand at full speed gets into anything at most, in meters; with edges that are not
/// rounded it gets as deep.
const DEEPEST: f32 = 0.006;

/// How deep it is there at most once it rests, in meters.
const AT_REST: f32 = 0.0005;

/// Half the edges of the closed fingers, along x and y, in meters.
const FINGERS: [f32; 2] = [0.0135, 0.0149];

/// How far above what it falls on a hand starts, in meters.
const DROP: f32 = 0.08;

/// Meters by which fingers overlap what they fall on or run into.
const OVERLAPS: [f32; 8] = [0.0001, 0.0003, 0.0004, 0.0006, 0.0008, 0.001, 0.002, 0.005];

/// The middle of the hole, and the height of the plate.
const HOLE: Position = Position::new(1.3, 0.7, 0.37);
const RIM: f32 = 0.44;

/// Half the edges of the plate and of its hole, in meters.
const PLATE: f32 = 0.1;
const HALF_HOLE: f32 = 0.02;

/// The middle of the top of the cabinet in `drawer`, and half its edges along x and y, in meters.
const TOP: Position = Position::new(1.5, 0.63, 0.488);
const TOP_HALF: [f32; 2] = [0.1, 0.11];

#[test]
fn a_hand_that_falls_on_an_edge_of_the_plate_does_not_get_into_it() {
    let mut deepest = 0.0_f32;
    for edge in [PLATE, -HALF_HOLE] {
        for overlap in OVERLAPS {
            let aside = |axis: usize| edge.abs() + (FINGERS[axis] - overlap) * edge.signum();
            for (x, y) in [(aside(0), 0.0), (0.0, aside(1)), (aside(0), aside(1))] {
                for sign in [1.0, -1.0] {
                    let mut stand = insert();
                    let start = HOLE + Vector3::new(x, y, 0.0) * sign;
                    let start = at_height(start, RIM + DROP);
                    deepest = deepest.max(fall(&mut stand, start, -Vector3::new(x, y, 0.0) * sign));
                }
            }
        }
    }
    println!("insert: a hand that falls on an edge gets {deepest} m into the plate");
    assert!(deepest < DEEPEST, "{deepest} m");
}

#[test]
fn a_hand_that_falls_on_an_edge_of_the_cabinet_does_not_get_into_it() {
    let mut deepest = 0.0_f32;
    for overlap in OVERLAPS {
        let [x, y] = [0, 1].map(|axis| TOP_HALF[axis] + FINGERS[axis] - overlap);
        for beside in [[-x, 0.0], [-x, -y], [-x, y], [0.0, -y], [0.0, y]] {
            let mut stand = Stand::new(Simulation::<Drawer, 1>::new());
            let aside = Vector3::new(beside[0], beside[1], 0.0);
            let start = at_height(TOP + aside, TOP.z + FINGERTIP + DROP);
            deepest = deepest.max(fall(&mut stand, start, -aside));
        }
    }
    println!("drawer: a hand that falls on an edge gets {deepest} m into the cabinet");
    assert!(deepest < DEEPEST, "{deepest} m");
}

/// Falls at full speed, straight and with a push inwards, and says how deep it gets.
fn fall<E: Simulated<1>>(stand: &mut Stand<E>, start: Position, inwards: Vector3<f32>) -> f32 {
    let inwards = inwards.normalize();
    let mut deepest = 0.0_f32;
    stand.go_to(at_height(start, 0.62), 0.0);
    stand.go_to(start, 0.0);
    stand.repeat(3, [0.0; 4]);
    let state = (stand.env.snapshot().unwrap(), stand.scene);
    for push in [0.0, 0.1, 1.0] {
        stand.env.return_to(&state.0).unwrap();
        stand.scene = state.1;
        let push = inwards * push;
        for _ in 0..25 {
            stand.step([push.x, push.y, -1.0, 0.0]);
            deepest = deepest.max(depth(&stand.env.things()));
        }
        stand.repeat(5, [0.0; 4]);
        let rests = depth(&stand.env.things());
        assert!(rests < AT_REST, "{rests} m deep after a fall from {start}");
    }
    deepest
}

#[test]
fn a_hand_that_runs_into_an_edge_of_the_plate_does_not_get_into_it() {
    let mut deepest = 0.0_f32;
    for overlap in OVERLAPS {
        for way in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()] {
            for aside in [-0.114, -0.06, 0.0, 0.06, 0.114] {
                let start = HOLE - way * 0.13 + Vector3::new(way.y, way.x, 0.0) * aside;
                let mut stand = insert();
                stand.go_to(at_height(start, 0.5), 0.0);
                stand.go_to(at_height(start, RIM - overlap), 0.0);
                for _ in 0..15 {
                    stand.step([way.x, way.y, -0.05, 0.0]);
                    deepest = deepest.max(depth(&stand.env.things()));
                }
            }
        }
    }
    println!("insert: a hand that runs into an edge gets {deepest} m into the plate");
    assert!(deepest < DEEPEST, "{deepest} m");
}

#[test]
fn a_hand_that_is_a_millimeter_below_an_edge_is_stopped() {
    for way in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()] {
        let start = at_height(HOLE - way * 0.13, RIM - 0.0015);
        let mut stand = insert();
        stand.go_to(at_height(start, 0.5), 0.0);
        // The fingers end half a millimeter below what is called their tip.
        for _ in 0..30 {
            let [x, y, z]: [f32; 3] = ((start - stand.scene.gripper) * 10.0).into();
            stand.step([x, y, z, 0.0]);
        }
        stand.repeat(20, [way.x * 0.2, way.y * 0.2, 0.0, 0.0]);
        let moved = (stand.scene.gripper - start).dot(&way);
        assert!(moved < 0.02, "{way:?}: over the edge by {moved} m, at {}", stand.scene.gripper);
    }
}

#[test]
fn random_actions_do_not_get_a_hand_into_the_plate() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut deepest = 0.0_f32;
    for seed in 0..300 {
        let mut stand = insert();
        stand.reset(seed);
        for _ in 0..50 {
            let [x, y, z, _] = random_action(&mut rng);
            for _ in 0..2 {
                stand.step([x, y, z - 0.3, 0.0]);
                deepest = deepest.max(depth(&stand.env.things()));
            }
        }
    }
    println!("insert: random actions get a hand {deepest} m into the plate");
    assert!(deepest < DEEPEST, "{deepest} m");
}

fn insert() -> Stand<Simulation<Insert, 1>> {
    let mut stand = Stand::new(Simulation::new());
    stand.arrange([HOLE]);
    stand
}

/// How deep the fingers are in the plate or the cabinet, by the shortest way out of each part.
fn depth(things: &[Thing]) -> f32 {
    let boxes = |names: &'static [&str]| {
        let things = things.iter().filter(|thing| names.contains(&thing.name.as_str()));
        things.flat_map(|thing| thing.shapes.iter().map(move |shape| (thing, shape))).map(
            |(thing, shape)| match shape.form {
                Form::Box(half) => ((thing.pose * shape.pose).translation.vector, half),
                _ => panic!("{} is no box", thing.name),
            },
        )
    };
    let fingers: Vec<_> = boxes(&["fingers"]).collect();
    assert_eq!(fingers.len(), 1);
    boxes(&["plate", "cabinet", "drawer"])
        .map(|(middle, half)| (half + fingers[0].1 - (middle - fingers[0].0).abs()).min())
        .fold(0.0, f32::max)
}
