//! The hole of Insert.

use crate::support::{Stand, at_height, flat, solved, towards};
use rher_core::goal::Position;
use rher_envs::tasks::Insert;
use rher_envs::{ACTION_WIDTH, Layout, Simulated, Simulation};

/// Height of the plate's rim, in meters.
const RIM: f32 = 0.44;

fn insert() -> Stand<Simulation<Insert, 1>> {
    Stand::new(Simulation::new())
}

#[test]
fn a_controller_inserts() {
    let solved = solved(insert, || insert_controller);
    assert!(solved >= 98, "{solved} of 100");
}

/// Above the hole, and down.
fn insert_controller<E: Simulated<1>>(stand: &Stand<E>, target: Position) -> [f32; ACTION_WIDTH] {
    let tip = stand.scene.gripper;
    if flat(target - tip).norm() < 0.004 || tip.z < RIM - 0.005 {
        towards(target, tip, 0.0)
    } else {
        towards(at_height(target, RIM + 0.02), tip, 0.0)
    }
}

/// The tip of a gripper over a hole in the middle of the table.
fn over_the_hole() -> Stand<Simulation<Insert, 1>> {
    let mut insert = insert();
    let target = Position::new(1.3419, 0.7491, 0.37);
    let layout = Layout::new([at_height(target, RIM)], [target]);
    let start = insert.env.arrange(layout, &mut insert.observation).unwrap();
    insert.scene = start.achieved.0;
    insert
}

#[test]
fn the_object_is_the_rim_until_the_tip_is_in_the_hole() {
    let mut insert = over_the_hole();
    let rim = Position::new(1.3419, 0.7491, RIM);
    assert_eq!(insert.block(), rim);
    insert.repeat(20, [0.0, 0.0, -1.0, 0.0]);
    assert_eq!(insert.block(), insert.scene.gripper);
    insert.repeat(20, [0.0, 0.0, 1.0, 0.0]);
    assert_eq!(insert.block(), rim);
}

#[test]
fn the_gripper_ends_on_the_bottom_of_the_hole() {
    let mut insert = over_the_hole();
    insert.repeat(30, [0.0, 0.0, -1.0, 0.0]);
    let tip = insert.scene.gripper.z;
    assert!((tip - 0.36).abs() < 0.002, "tip at {tip} m");
}

#[test]
fn the_walls_of_the_hole_hold_at_full_force() {
    for (x, y, room) in [(1.0, 0.0, 0.0065), (-1.0, 0.0, 0.0065), (0.0, 1.0, 0.0051)] {
        let mut insert = over_the_hole();
        insert.repeat(15, [0.0, 0.0, -1.0, 0.0]);
        let start = insert.scene.gripper;
        for _ in 0..50 {
            insert.step([x, y, 0.0, 0.0]);
            let moved = flat(insert.scene.gripper - start).norm();
            // It runs into the wall at half its full speed.
            assert!(moved < room + 0.004, "into the wall by {} m", moved - room);
        }
    }
}

#[test]
fn the_plate_stops_a_tip_that_misses_the_hole() {
    let mut insert = over_the_hole();
    insert.repeat(2, [1.0, 0.0, 0.0, 0.0]);
    insert.repeat(30, [0.0, 0.0, -1.0, 0.0]);
    let tip = insert.scene.gripper.z;
    assert!((tip - RIM).abs() < 0.002, "tip at {tip} m");
}
