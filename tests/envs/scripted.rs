//! Controllers written by hand solve the tasks.

use crate::support::{Stand, at_height, flat, pick, push, solved, towards};
use rher_core::goal::Position;
use rher_envs::{ACTION_WIDTH, Simulated};

/// Height of the grip center at which closed fingers push a block, in meters.
pub(crate) const PUSH_HEIGHT: f32 = 0.425;

/// Height at which the hand passes over a block, in meters.
pub(crate) const PASS_HEIGHT: f32 = 0.5;

/// What the fingers do.
const OPEN: f32 = 1.0;
const CLOSE: f32 = -1.0;

#[test]
fn a_controller_pushes() {
    let solved = solved(push, || push_controller);
    assert!(solved >= 98, "{solved} of 100");
}

#[test]
fn a_controller_picks_and_places() {
    let solved = solved(pick, || {
        let mut steps_closed = 0;
        move |stand: &Stand<_>, target| pick_controller(stand, target, &mut steps_closed)
    });
    assert!(solved >= 98, "{solved} of 100");
}

/// Around the block to the side away from the target, down, and on to the target.
pub(crate) fn push_controller<E: Simulated<1>>(
    stand: &Stand<E>,
    target: Position,
) -> [f32; ACTION_WIDTH] {
    let (hand, block) = (stand.scene.gripper, stand.block());
    let way = flat(target - block);
    if way.norm() < 0.01 {
        return [0.0; 4];
    }
    let ahead = way.normalize();
    let behind = at_height(block - ahead * 0.06, PUSH_HEIGHT);
    let offset = flat(hand - block);
    let along = offset.dot(&ahead);
    let aside = (offset - ahead * along).norm();

    if along < -0.03 && aside < 0.012 && hand.z < PASS_HEIGHT - 0.04 {
        // Slower the nearer, since the block glides on.
        let speed = (way.norm() * 12.0).clamp(0.15, 0.8);
        let centered = block - ahead * 0.035;
        let correction = flat(centered - hand) * 8.0;
        let correction = correction - ahead * correction.dot(&ahead);
        let push = ahead * speed + correction;
        [push.x, push.y, (PUSH_HEIGHT - hand.z) * 20.0, 0.0]
    } else if flat(behind - hand).norm() > 0.012 {
        let above = at_height(behind, PASS_HEIGHT);
        let clear = hand.z > PASS_HEIGHT - 0.03 || offset.norm() > 0.08;
        let mut action = towards(above, hand, 0.0);
        if !clear {
            action[0] = 0.0;
            action[1] = 0.0;
        }
        action
    } else {
        towards(behind, hand, 0.0)
    }
}

/// Above the block, down, close, and to the target.
fn pick_controller<E: Simulated<1>>(
    stand: &Stand<E>,
    target: Position,
    steps_closed: &mut usize,
) -> [f32; ACTION_WIDTH] {
    let (hand, block) = (stand.scene.gripper, stand.block());
    if flat(block - hand).norm() > 0.015 {
        *steps_closed = 0;
        return towards(at_height(block, PASS_HEIGHT), hand, OPEN);
    }
    if *steps_closed == 0 && hand.z > block.z + 0.008 {
        return towards(block, hand, OPEN);
    }
    *steps_closed += 1;
    if *steps_closed < 4 {
        return [0.0, 0.0, 0.0, CLOSE];
    }
    towards(hand + (target - block), hand, CLOSE)
}
