//! What a gripper and a block must and must not do, at the settings that are trained with.

use crate::support::{BLOCK_HEIGHT, FINGERTIP, HALF_BLOCK, Stand, pick, push, random_action};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::Position;
use rher_envs::{EnvVisitor, Simulated, Task};

/// y of the robot's middle plane, in meters.
const MIDDLE: f32 = 0.7491;

#[test]
fn a_gripped_block_is_lifted_and_held() {
    let mut pick = pick();
    grip(&mut pick);
    let before = pick.held();
    pick.go_to(Position::new(1.34, MIDDLE, BLOCK_HEIGHT + 0.2), -1.0);
    pick.repeat(125, [0.0, 0.0, 0.0, -1.0]);
    let slip = (pick.held() - before).norm();
    assert!(pick.block().z > BLOCK_HEIGHT + 0.19, "at {:?}", pick.scene);
    assert!(slip < 0.002, "slipped by {slip} m");
}

#[test]
fn a_gripped_block_survives_a_shuttle_at_full_speed() {
    for axis in 0..3 {
        let mut pick = pick();
        grip(&mut pick);
        pick.go_to(Position::new(1.34, MIDDLE, 0.6), -1.0);
        let before = pick.held();
        for turn in 0..12 {
            let mut action = [0.0, 0.0, 0.0, -1.0];
            action[axis] = if turn % 2 == 0 { 1.0 } else { -1.0 };
            pick.repeat(4, action);
        }
        pick.repeat(5, [0.0, 0.0, 0.0, -1.0]);
        let slip = (pick.held() - before).norm();
        assert!(slip < 0.002, "along axis {axis} slipped by {slip} m");
    }
}

#[test]
fn pressing_a_block_on_the_table_neither_sinks_nor_ejects_it() {
    for (dx, dy) in [(0.0, 0.0), (0.01, 0.0), (0.0, 0.012)] {
        let mut pick = pick();
        pick.put(1.34 + dx, MIDDLE + dy);
        let start = pick.block();
        for _ in 0..50 {
            pick.step([0.0, 0.0, -1.0, -1.0]);
            let sunk = BLOCK_HEIGHT - pick.block().z;
            let inside = pick.block().z + HALF_BLOCK - (pick.scene.gripper.z - FINGERTIP);
            assert!(sunk < 0.003 && inside < 0.003, "sunk by {sunk} m, {inside} m deep");
        }
        pick.repeat(10, [0.0, 0.0, 1.0, 0.0]);
        let moved = (pick.block() - start).norm();
        assert!(moved < 0.005, "moved by {moved} m");
    }
}

#[test]
fn fingers_pressed_on_the_table_stay_above_it() {
    let mut push = push();
    push.put(1.5, 0.6);
    push.repeat(20, [0.0, 0.0, -1.0, 0.0]);
    let depth = 0.4 - (push.scene.gripper.z - FINGERTIP);
    assert!(depth < 0.002, "{depth} m deep");
}

#[test]
fn nothing_passes_through_a_block_at_full_speed() {
    for aside in [-0.03, -0.02, -0.01, 0.0, 0.01, 0.02, 0.03] {
        for distance in [0.06, 0.067, 0.075, 0.083, 0.09] {
            let mut push = push();
            push.put(1.363 + distance, MIDDLE + aside);
            let start = push.block();
            push.repeat(5, [1.0, 0.0, 0.05, 0.0]);
            let moved = (push.block() - start).norm();
            assert!(moved > 0.015, "{aside} m aside, {distance} m away: moved by {moved} m");
        }
    }
}

#[test]
fn a_block_falls_once_its_center_is_past_the_edge() {
    for (beyond, falls) in [(-0.005, false), (0.003, true), (0.008, true)] {
        let mut push = push();
        push.put(1.55 + beyond, 0.9);
        push.repeat(50, [0.0; 4]);
        assert_eq!(push.block().z < 0.4, falls, "{beyond} m past it: {}", push.block());
    }
}

#[test]
fn a_block_at_rest_stays_where_it_is() {
    let mut push = push();
    push.put(1.45, 0.85);
    let start = push.block();
    push.repeat(50, [0.0; 4]);
    let moved = (push.block() - start).norm();
    assert!(moved < 2e-4, "moved by {moved} m");
}

#[test]
fn nothing_explodes_under_random_actions() {
    let with_blocks = [Task::PUSH, Task::PICK, Task::DPUSH, Task::STACK, Task::TPUSH, Task::TSTACK];
    for task in with_blocks.into_iter().chain([Task::DRAWER, Task::DRAWER_BOX]) {
        task.visit(CheckSpeeds(task));
    }
}

struct CheckSpeeds(Task);

impl EnvVisitor for CheckSpeeds {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let task = self.0;
        let mut stand = Stand::new(build());
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (mut hand, mut object) = (0.0_f32, 0.0_f32);
        for seed in 0..100 {
            stand.reset(seed);
            for _ in 0..stand.env.spec().episode_steps {
                let before = stand.scene;
                stand.step(random_action(&mut rng));
                hand = hand.max((stand.scene.gripper - before.gripper).norm() / 0.04);
                for (now, before) in stand.scene.objects.iter().zip(before.objects) {
                    object = object.max((now - before).norm() / 0.04);
                }
            }
        }
        println!("{task}: hand up to {hand} m/s, objects up to {object} m/s");
        // What leaves the table falls at up to 2.8 m/s.
        assert!(hand < 2.0 && object < 3.3, "{task}: hand {hand} m/s, objects {object} m/s");
    }
}

/// Grips a block in the middle of the table.
fn grip<E: Simulated<1>>(stand: &mut Stand<E>) {
    stand.put(1.34, MIDDLE);
    stand.repeat(3, [0.0, 0.0, 0.0, 1.0]);
    stand.go_to(Position::new(1.34, MIDDLE, BLOCK_HEIGHT), 1.0);
    stand.repeat(8, [0.0, 0.0, 0.0, -1.0]);
}
