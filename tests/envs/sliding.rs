//! What slides over a flat surface under a light press is not stopped, whatever the surface is
//! made of.

use crate::strokes::{CLOSE, HIGH, OPEN, STROKES, Tally, Track, slide, slide_where, stroke};
use crate::support::{Stand, at_height, seen_clearly};
use nalgebra::Vector3;
use rher_core::goal::Position;
use rher_envs::tasks::{
    CuePush, DPush, Drawer, DrawerBox, Insert, ObstaclePush, Pick, Push, Reach, Slide, Stack,
    TPush, TStack,
};
use rher_envs::{Simulated, Simulation, Task};

/// Half the edges of the closed fingers, in meters.
const FINGERS: Vector3<f32> = Vector3::new(0.0135, 0.0149, 0.0385);

/// From the middle of the fingers to the grip center, in meters.
const GRIP: Vector3<f32> = Vector3::new(0.0, 0.0, -0.019);

/// From the middle of the fingers to what `insert` calls the gripper, in meters.
const TIP: Vector3<f32> = Vector3::new(0.0, 0.0, -0.039);

/// Half the edges of a block, in meters.
const BLOCK: Vector3<f32> = Vector3::new(0.025, 0.025, 0.025);

const UP: [f32; 3] = [0.0, 0.0, 1.0];

#[test]
fn a_hand_slides_over_every_table() {
    /// `away` is where the objects are out of the way, in a row.
    fn check<E: Simulated<N>, const N: usize>(env: E, height: f32, middle: f32, away: f32) {
        let place = |object| Position::new(away, 0.47 + 0.07 * object as f32, height + 0.025);
        let mut stand = Stand::new(env);
        stand.arrange(std::array::from_fn(place));
        let name = stand.env.spec().name.clone();
        let half = [0.06, 0.08];
        let corner = |sign: f32| [middle + sign * half[0], 0.75 + sign * half[1], height];
        let track = Track::over([corner(-1.0), corner(1.0)], UP, FINGERS).moved(GRIP);
        slide(&mut stand, &format!("table of {name}"), &track, &STROKES).check();
    }
    check(Simulation::<Reach, 1>::new(), 0.4, 1.34, 1.5);
    check(Simulation::<Push, 1>::new(), 0.4, 1.34, 1.5);
    check(Simulation::<Pick, 1>::new(), 0.4, 1.34, 1.5);
    check(Simulation::<Slide, 1>::new(), 0.4, 0.95, 1.5);
    check(Simulation::<ObstaclePush, 1>::new(), 0.4, 1.34, 1.5);
    check(Simulation::<DPush, 2>::new(), 0.4, 1.34, 1.5);
    check(Simulation::<Stack, 2>::new(), 0.4, 1.34, 1.5);
    check(Simulation::<TPush, 3>::new(), 0.4, 1.34, 1.5);
    check(Simulation::<TStack, 3>::new(), 0.4, 1.34, 1.5);
}

#[test]
fn a_hand_slides_over_two_flush_blocks() {
    let mut stand = Stand::new(Simulation::<DPush, 2>::new());
    let block = Position::new(1.31, 0.75, 0.425);
    stand.arrange([block, block + Vector3::x() * (2.0 * BLOCK.x)]);
    stand.go_to(at_height(stand.scene.gripper, HIGH), CLOSE);
    let track = Track::over([[1.29, 0.73, 0.45], [1.38, 0.77, 0.45]], UP, FINGERS).moved(GRIP);
    slide(&mut stand, "two blocks", &track, &STROKES).check();
}

#[test]
fn a_hand_slides_over_the_plate_and_beside_it() {
    let hole = Position::new(1.3, 0.7, 0.37);
    let mut stand = Stand::new(Simulation::<Insert, 1>::new());
    stand.arrange([hole]);
    let from_hole = hole - Position::origin();
    for (name, corners, out) in [
        ("plate", [[-0.085, -0.085, 0.07], [0.085, 0.085, 0.07]], UP),
        ("-x of the plate", [[-0.1, -0.07, 0.06], [-0.1, 0.07, 0.1]], [-1.0, 0.0, 0.0]),
        ("+x of the plate", [[0.1, -0.07, 0.06], [0.1, 0.07, 0.1]], [1.0, 0.0, 0.0]),
        ("-y of the plate", [[-0.07, -0.1, 0.06], [0.07, -0.1, 0.1]], [0.0, -1.0, 0.0]),
        ("+y of the plate", [[-0.07, 0.1, 0.06], [0.07, 0.1, 0.1]], [0.0, 1.0, 0.0]),
        ("table of insert", [[-0.12, 0.16, -0.01], [0.08, 0.24, -0.01]], UP),
    ] {
        let track = Track::over(corners, out, FINGERS).moved(from_hole).moved(TIP);
        // Over the middle of the hole the hand falls in.
        let falls =
            |from: Position, along: usize| out == UP && (from - hole)[1 - along].abs() < 0.0065;
        slide_where(&mut stand, name, &track, &STROKES, |from, along| !falls(from, along)).check();
    }
}

/// From the handle of the closed drawer to the middle of the foot of the cabinet, in meters.
const FOOT: Vector3<f32> = Vector3::new(0.124, 0.0, -0.13);

/// Where the handle of the closed drawer is, in meters.
const HANDLE: Position = Position::new(1.28, 0.775, 0.45);

/// Its name, its corners, and where it faces.
type Face = (&'static str, [[f32; 3]; 2], [f32; 3]);

/// What a hand reaches of the closed cabinet, from its foot. As for the drawer, the lowest point of
/// a hand is 11 cm above the foot, its middle 15 cm.
const CABINET: &[Face] = &[
    ("top of the cabinet", [[-0.09, -0.1, 0.168], [0.08, 0.1, 0.168]], UP),
    ("front of the cabinet", [[-0.1, -0.1, 0.177], [-0.1, 0.1, 0.196]], [-1.0, 0.0, 0.0]),
    ("front, -y", [[-0.1, -0.1, 0.151], [-0.1, -0.075, 0.196]], [-1.0, 0.0, 0.0]),
    ("front, +y", [[-0.1, 0.075, 0.151], [-0.1, 0.1, 0.196]], [-1.0, 0.0, 0.0]),
    ("back of the cabinet", [[0.1, -0.1, 0.151], [0.1, 0.1, 0.196]], [1.0, 0.0, 0.0]),
    ("-y of the cabinet", [[-0.09, -0.11, 0.151], [0.08, -0.11, 0.196]], [0.0, -1.0, 0.0]),
    ("+y of the cabinet", [[-0.09, 0.11, 0.151], [0.08, 0.11, 0.196]], [0.0, 1.0, 0.0]),
    ("bar of the handle", [[-0.156, -0.05, 0.135], [-0.148, 0.05, 0.135]], UP),
    ("holder of the handle", [[-0.15, 0.045, 0.135], [-0.115, 0.055, 0.135]], UP),
    ("front of the handle", [[-0.158, -0.05, 0.151], [-0.158, 0.05, 0.164]], [-1.0, 0.0, 0.0]),
    ("-y of the handle", [[-0.155, -0.056, 0.151], [-0.116, -0.056, 0.164]], [0.0, -1.0, 0.0]),
    ("+y of the handle", [[-0.155, 0.056, 0.151], [-0.116, 0.056, 0.164]], [0.0, 1.0, 0.0]),
];

/// The same of a drawer that is open, from the foot of a closed one.
const DRAWER: &[Face] = &[
    ("rim of the drawer's back", [[0.07, -0.09, 0.135], [0.08, 0.09, 0.135]], UP),
    ("rim of the drawer's side", [[-0.07, 0.085, 0.135], [0.08, 0.095, 0.135]], UP),
    ("-y of the drawer", [[-0.09, -0.095, 0.151], [0.06, -0.095, 0.165]], [0.0, -1.0, 0.0]),
    ("+y of the drawer", [[-0.09, 0.095, 0.151], [0.06, 0.095, 0.165]], [0.0, 1.0, 0.0]),
    ("front, from inside", [[-0.09, -0.065, 0.151], [-0.09, 0.065, 0.165]], [1.0, 0.0, 0.0]),
    ("back, from inside", [[0.073, -0.065, 0.151], [0.073, 0.065, 0.165]], [-1.0, 0.0, 0.0]),
    ("-y, from inside", [[-0.07, -0.085, 0.151], [0.055, -0.085, 0.165]], [0.0, 1.0, 0.0]),
    ("+y, from inside", [[-0.07, 0.085, 0.151], [0.055, 0.085, 0.165]], [0.0, -1.0, 0.0]),
];

/// The place of a block in the closed drawer.
const IN_DRAWER: Position = Position::new(1.38, 0.775, 0.42);

/// From the middle of a block in the drawer to the grip center of a hand that holds it, in meters.
const HOLD: Vector3<f32> = Vector3::new(0.0, 0.0, 0.036);

#[test]
fn a_hand_slides_over_the_cabinet() {
    let mut stand = Stand::new(Simulation::<DrawerBox, 2>::new());
    stand.arrange([HANDLE, IN_DRAWER]);
    for (name, corners, out) in CABINET {
        let track = Track::over(*corners, *out, FINGERS).moved(foot() + GRIP);
        slide(&mut stand, name, &track, &STROKES).check();
    }
}

#[test]
fn a_hand_slides_over_an_open_drawer() {
    let mut stand = Stand::new(Simulation::<Drawer, 1>::new());
    let closed = stand.scene.objects[0];
    let opened = closed - Vector3::x() * 0.2;
    stand.arrange([opened]);
    for (name, corners, out) in DRAWER {
        let foot = opened + FOOT - Position::origin();
        let track = Track::over(*corners, *out, FINGERS).moved(foot + GRIP);
        slide(&mut stand, name, &track, &STROKES).check();
    }
}

fn foot() -> Vector3<f32> {
    HANDLE + FOOT - Position::origin()
}

#[test]
fn a_held_block_slides() {
    let mut pick = Stand::new(Simulation::<Pick, 1>::new());
    let block = Position::new(1.34, 0.75, 0.425);
    pick.arrange([block]);
    let held = grip(&mut pick, block);
    let track = Track::over([[1.28, 0.67, 0.4], [1.4, 0.83, 0.4]], UP, BLOCK).moved(held);
    slide(&mut pick, "held block on the table", &track, &STROKES).check();

    let mut stand = Stand::new(Simulation::<DrawerBox, 2>::new());
    let block = on_cabinet(0.0, 0.0);
    stand.arrange([HANDLE, block]);
    let held = grip(&mut stand, block);
    let (_, top, _) = CABINET[0];
    // With less, its weight of 40 N stops it.
    let strokes = &STROKES[2..];
    let track = Track::over(top, UP, BLOCK).moved(foot() + held);
    slide(&mut stand, "held block on the cabinet", &track, strokes).check();

    let mut stand = Stand::new(Simulation::<DrawerBox, 2>::new());
    stand.arrange([HANDLE, IN_DRAWER]);
    stand.go_to(at_height(HANDLE, HIGH), CLOSE);
    stand.go_to(HANDLE, CLOSE);
    stand.repeat(12, [-0.7, 0.0, 0.0, CLOSE]);
    stand.repeat(5, [0.0, 0.0, 1.0, CLOSE]);
    let [handle, block] = stand.scene.objects;
    let held = grip(&mut stand, block + HOLD);
    let floor = [[-0.05, -0.04, 0.075], [0.03, 0.04, 0.075]];
    let track = Track::over(floor, UP, BLOCK).moved(handle + FOOT + held - Position::origin());
    slide(&mut stand, "held block in the drawer", &track, strokes).check();
}

/// Grips the last object at a place, lifts it, and says where the hand is from its middle.
fn grip<E: Simulated<N>, const N: usize>(stand: &mut Stand<E, N>, place: Position) -> Vector3<f32> {
    stand.go_to(at_height(place, HIGH), OPEN);
    stand.go_to(place, 0.0);
    stand.repeat(8, [0.0, 0.0, 0.0, CLOSE]);
    stand.go_to(at_height(place, HIGH), CLOSE);
    let lifted = stand.scene.objects[N - 1];
    assert!(lifted.z > HIGH - 0.05, "it is at {lifted}");
    stand.scene.gripper - lifted
}

/// The place of a block on top of the cabinet, from the middle of its foot.
fn on_cabinet(x: f32, y: f32) -> Position {
    Position::origin() + foot() + Vector3::new(x, y, 0.168 + BLOCK.z)
}

#[test]
fn what_is_pushed_slides() {
    let ways = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()];
    let (mut block, mut puck, mut cylinder, mut on_top) = Default::default();
    for way in ways {
        for aside in [-0.04, -0.02, 0.0, 0.02, 0.04] {
            let from = Vector3::new(way.y, way.x, 0.0) * aside - way * 0.07;
            for speed in [0.2, 0.5, 1.0] {
                let mut stand = Stand::new(Simulation::<Push, 1>::new());
                stand.arrange([Position::new(1.34, 0.75, 0.425) + from]);
                push(&mut stand, 0, way * speed, 0.14, [0.046, 0.425], &mut block);

                let mut stand = Stand::new(Simulation::<Slide, 1>::new());
                stand.arrange([Position::new(0.87, 0.75, 0.42) + from]);
                push(&mut stand, 0, way * speed, 0.14, [0.046, 0.425], &mut puck);

                let clearly = seen_clearly(Task::CUE_PUSH);
                let mut stand = Stand::new(Simulation::<CuePush, 1>::with(&clearly).unwrap());
                stand.arrange([Position::new(1.3, 0.75, 0.415) + from * 0.15]);
                push(&mut stand, 0, way * speed, 0.03, [0.034, 0.41], &mut cylinder);

                let mut stand = Stand::new(Simulation::<DrawerBox, 2>::new());
                stand.arrange([HANDLE, on_cabinet(from.x, from.y)]);
                push(&mut stand, 1, way * speed, 0.14, [0.046, 0.513], &mut on_top);
            }
        }
    }
    for (name, tally) in [
        ("pushed block on the table", block),
        ("pushed puck", puck),
        ("pushed cylinder", cylinder),
        ("pushed block on the cabinet", on_top),
    ] {
        Tally { surface: name.to_owned(), ..tally }.check();
    }
}

/// Pushes an object by `length`, with the hand `gap` behind its middle and at a height.
fn push<E: Simulated<N>, const N: usize>(
    stand: &mut Stand<E, N>,
    object: usize,
    action: Vector3<f32>,
    length: f32,
    [gap, height]: [f32; 2],
    tally: &mut Tally,
) {
    let start = stand.scene.objects[object];
    let way = action.normalize();
    let behind = at_height(start - way * gap, height);
    stand.go_to(at_height(stand.scene.gripper, HIGH), CLOSE);
    stand.go_to(at_height(behind, HIGH), CLOSE);
    stand.go_to(behind, CLOSE);
    let off = (stand.scene.gripper - behind).norm();
    assert!(off < 0.004, "{off} m from {behind}, where a hand begins to push");
    let stopped = stroke(stand, action, Vector3::zeros(), behind + way * length);
    let moved = (stand.scene.objects[object] - start).dot(&way);
    let pushed = (stand.scene.gripper - behind).dot(&way);
    tally.strokes += 1;
    tally.touched += usize::from(moved > 0.0);
    if stopped.is_some() || moved < pushed - 0.01 {
        tally.stopped.push(format!(
            "from {start} by {action:?}: {moved} m, the hand {pushed} m {stopped:?}"
        ));
    }
}
