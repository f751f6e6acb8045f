//! The puck of Slide.

use crate::scripted::PASS_HEIGHT;
use crate::support::{Stand, at_height, flat, solved, towards};
use nalgebra::Vector3;
use rher_core::goal::Position;
use rher_envs::tasks::Slide;
use rher_envs::{ACTION_WIDTH, Layout, Simulated, Simulation};

/// What friction takes from a sliding puck, in meters per second squared.
const SLOWS_BY: f32 = 0.1 * 9.81;

/// How far behind the puck the hand starts, in meters.
const RUN_UP: f32 = 0.07;

/// Meters.
const PUCK_RADIUS: f32 = 0.025;

/// Height of the grip center at which closed fingers push the puck, in meters.
const PUSH_HEIGHT: f32 = 0.421;

fn slide() -> Stand<Simulation<Slide, 1>> {
    Stand::new(Simulation::new())
}

#[test]
fn a_controller_slides() {
    let solved = solved(slide, || {
        let mut controller = Slider::default();
        move |stand: &Stand<_>, target| controller.act(stand, target)
    });
    assert!(solved >= 80, "{solved} of 100");
}

/// Behind the puck, forward until it is fast enough to get there by itself, and stop.
#[derive(Default)]
struct Slider {
    /// Whether the target is so far that the hand cannot be too fast; told at the first step.
    is_far: Option<bool>,
    has_let_go: bool,
}

impl Slider {
    fn act<E: Simulated<1>>(&mut self, stand: &Stand<E>, target: Position) -> [f32; ACTION_WIDTH] {
        let (hand, puck) = (stand.scene.gripper, stand.block());
        let way = flat(target - puck);
        let ahead = way.try_normalize(1e-6).unwrap_or_default();
        let is_far = *self.is_far.get_or_insert(way.norm() > 0.5);
        let speed = velocity(stand).dot(&ahead);
        let glide = speed * speed / (2.0 * SLOWS_BY);
        self.has_let_go |= glide + 0.04 * speed > way.norm() || speed > 0.1 && hand.x > target.x;
        if self.has_let_go {
            return [0.0, 0.0, 0.5, 0.0];
        }
        let touching = puck - ahead * PUCK_RADIUS - foremost(ahead);
        let offset = flat(hand - touching);
        let along = offset.dot(&ahead);
        let aside = offset - ahead * along;
        let is_moving = speed > 0.2;
        let in_line = if is_moving { 0.05 } else { 0.006 };
        if along < 0.01 && aside.norm() < in_line && hand.z < PUSH_HEIGHT + 0.01 {
            let fastest = 1.0 / ahead.amax();
            // The puck leaves a little faster than it is hit.
            let wanted = (2.0 * SLOWS_BY * (way.norm() - 0.035).max(0.0)).sqrt() / 0.96;
            let push = ahead * if is_far { fastest } else { wanted.min(fastest) };
            let push = push - aside * if is_moving { 5.0 } else { 20.0 };
            return [push.x, push.y, (PUSH_HEIGHT - hand.z) * 20.0, 0.0];
        }
        let behind = at_height(touching - ahead * RUN_UP, PUSH_HEIGHT);
        if flat(behind - hand).norm() < 0.005 {
            towards(behind, hand, 0.0)
        } else if hand.z < PASS_HEIGHT - 0.03 {
            [0.0, 0.0, 1.0, 0.0]
        } else {
            towards(at_height(behind, PASS_HEIGHT), hand, 0.0)
        }
    }
}

/// From the middle of the hand to where it should touch: a face pushes along its normal, a corner
/// along any direction.
fn foremost(ahead: Vector3<f32>) -> Vector3<f32> {
    let along = |axis: usize, half: f32| if ahead[axis].abs() < 0.12 { 0.0 } else { half };
    Vector3::new(along(0, 0.0135).copysign(ahead.x), along(1, 0.0149).copysign(ahead.y), 0.0)
}

/// Of the puck, in meters per second.
fn velocity<E>(stand: &Stand<E>) -> Vector3<f32> {
    let o = &stand.observation;
    Vector3::new(o[14] + o[20], o[15] + o[21], 0.0) / 0.04
}

#[test]
fn a_puck_glides_as_far_as_its_friction_lets_it() {
    let mut slide = slide();
    let puck = Position::new(1.15, 0.7491, 0.42);
    let start = slide.env.arrange(Layout::new([puck], [puck]), &mut slide.observation).unwrap();
    slide.scene = start.achieved.0;
    slide.repeat(8, [0.8, 0.0, 0.1, 0.0]);
    slide.repeat(2, [-1.0, 0.0, 0.1, 0.0]);
    let (from, speed) = (slide.block(), velocity(&slide).norm());
    let mut last = speed;
    for _ in 0..40 {
        slide.step([-0.2, 0.0, 1.0, 0.0]);
        let now = velocity(&slide).norm();
        assert!(now < last + 1e-3, "faster by itself: {last}, then {now} m/s");
        last = now;
    }
    let (glided, expected) = ((slide.block() - from).norm(), speed * speed / (2.0 * SLOWS_BY));
    assert!((glided - expected).abs() < 0.05 * expected, "{glided} m, expected {expected} m");
    assert!(velocity(&slide).norm() < 1e-4);
}

#[test]
fn the_hand_does_not_pass_through_the_puck() {
    for aside in [-0.03, -0.015, 0.0, 0.01, 0.02, 0.035] {
        let mut slide = slide();
        let puck = Position::new(1.2, 0.7491 + aside, 0.42);
        slide.env.arrange(Layout::new([puck], [puck]), &mut slide.observation).unwrap();
        for _ in 0..20 {
            slide.step([1.0, 0.0, 0.0, 0.0]);
            let apart = flat(slide.block() - slide.scene.gripper).norm();
            assert!(apart > PUCK_RADIUS + 0.0135 - 0.003, "{aside}: {apart} m apart");
        }
    }
}
