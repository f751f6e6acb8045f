//! The obstacle of `ObstaclePush`.

use crate::scripted::{PASS_HEIGHT, PUSH_HEIGHT};
use crate::support::{Stand, at_height, flat, solved, towards};
use nalgebra::Vector3;
use rher_core::goal::Position;
use rher_envs::tasks::ObstaclePush;
use rher_envs::{ACTION_WIDTH, Layout, Simulated, Simulation};
use std::f32::consts::TAU;

fn obstacle_push() -> Stand<Simulation<ObstaclePush, 1>> {
    Stand::new(Simulation::new())
}

#[test]
fn a_controller_pushes_round_the_obstacle() {
    let solved = solved(obstacle_push, || controller);
    assert!(solved >= 98, "{solved} of 100");
}

/// Half the edges, along x and y, of what the middle of a block keeps out of.
const BLOCK_KEEPS_OUT: [f32; 2] = [0.045, 0.075];

/// The same for the hand, when it is down.
const HAND_KEEPS_OUT: [f32; 2] = [0.026, 0.057];

/// Pushes to the next corner of the shortest way round the obstacle.
fn controller<E: Simulated<1>>(stand: &Stand<E>, target: Position) -> [f32; ACTION_WIDTH] {
    let obstacle = obstacle(&stand.observation);
    let block = stand.block();
    if flat(target - block).norm() < 0.01 {
        return [0.0; 4];
    }
    let way = |target: &Position| best_push(block, *target, obstacle);
    let shortest = places_near(target, obstacle).map(|target| way(&target)).into_iter();
    let (_, next) = shortest.min_by(|(a, _), (b, _)| a.total_cmp(b)).unwrap();
    push_to(stand, next, if next == target { 0.15 } else { 0.4 })
}

/// Where the obstacle stands: the observation tells it from the hand.
fn obstacle(observation: &[f32]) -> Position {
    Position::from_slice(&observation[..3]) + Vector3::from_column_slice(&observation[25..28])
}

/// The target itself or, where the obstacle is in the way, places beside the obstacle that are near
/// enough to it.
fn places_near(target: Position, obstacle: Position) -> [Position; 4] {
    if !inside(target, obstacle, BLOCK_KEEPS_OUT) {
        return [target; 4];
    }
    let [x, y] = BLOCK_KEEPS_OUT;
    let beside = [
        Position::new(obstacle.x + x, target.y, target.z),
        Position::new(obstacle.x - x, target.y, target.z),
        Position::new(target.x, obstacle.y + y, target.z),
        Position::new(target.x, obstacle.y - y, target.z),
    ];
    let far = |place: &Position| flat(place - target).norm();
    let nearest = beside.into_iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
    beside.map(|place| if far(&place) < 0.04 { place } else { nearest })
}

/// Behind the block, from above, and on to `next`.
fn push_to<E: Simulated<1>>(stand: &Stand<E>, next: Position, slowest: f32) -> [f32; ACTION_WIDTH] {
    let (hand, block) = (stand.scene.gripper, stand.block());
    let way = flat(next - block);
    let ahead = way.try_normalize(1e-6).unwrap_or_default();
    let offset = flat(hand - block);
    let along = offset.dot(&ahead);
    let aside = (offset - ahead * along).norm();
    if along < -0.03 && aside < 0.014 && hand.z < PASS_HEIGHT - 0.04 {
        // Slower the nearer, since the block glides on.
        let speed = (way.norm() * 12.0).clamp(slowest, 0.8);
        let correction = flat(block - ahead * 0.035 - hand) * 8.0;
        let push = ahead * speed + correction - ahead * correction.dot(&ahead);
        return [push.x, push.y, (PUSH_HEIGHT - hand.z) * 20.0, 0.0];
    }
    let behind = at_height(block - ahead * 0.06, PUSH_HEIGHT);
    if flat(behind - hand).norm() < 0.014 {
        towards(behind, hand, 0.0)
    } else if hand.z < PASS_HEIGHT - 0.03 {
        // Up first, and only then over there.
        [0.0, 0.0, 1.0, 0.0]
    } else {
        towards(at_height(behind, PASS_HEIGHT), hand, 0.0)
    }
}

/// Where to push the block next, and how long the whole way is.
#[expect(clippy::disallowed_methods, reason = "a script acts by it, which is judged by success")]
fn best_push(block: Position, target: Position, obstacle: Position) -> (f32, Position) {
    let (length, corner) = way_round(block, target, obstacle);
    let mut best = (if has_room(block, corner, obstacle) { length } else { f32::INFINITY }, corner);
    for i in 0..32 {
        let angle = TAU * i as f32 / 32.0;
        for step in [0.03, 0.06, 0.1] {
            let next = block + Vector3::new(angle.cos(), angle.sin(), 0.0) * step;
            if crosses(block, next, obstacle, BLOCK_KEEPS_OUT) || !has_room(block, next, obstacle) {
                continue;
            }
            let (rest, corner) = way_round(next, target, obstacle);
            if !has_room(next, corner, obstacle) {
                continue;
            }
            // A turn costs the time to get behind the block again.
            let length = step + rest + 0.1;
            if length < best.0 {
                best = (length, next);
            }
        }
    }
    best
}

/// Whether the hand has room behind a block that it pushes to `next`.
fn has_room(block: Position, next: Position, obstacle: Position) -> bool {
    let ahead = flat(next - block).try_normalize(1e-6).unwrap_or_default();
    let sweep = flat(next - block).norm();
    (-6..=30).map(|i| 0.01 * i as f32).take_while(|along| *along < sweep).all(|along| {
        let hand = block + ahead * (along - 0.035).max(-0.06);
        !inside(hand, obstacle, HAND_KEEPS_OUT)
    })
}

/// Length of the shortest way round the obstacle, and its first corner.
fn way_round(from: Position, to: Position, obstacle: Position) -> (f32, Position) {
    if !crosses(from, to, obstacle, BLOCK_KEEPS_OUT) {
        return (flat(to - from).norm(), to);
    }
    let [x, y] = BLOCK_KEEPS_OUT.map(|half| half + 0.002);
    let corners = [(x, y), (x, -y), (-x, -y), (-x, y)]
        .map(|(x, y)| Position::new(obstacle.x + x, obstacle.y + y, from.z));
    let mut best = (f32::INFINITY, to);
    for (i, first) in corners.iter().enumerate() {
        if crosses(from, *first, obstacle, BLOCK_KEEPS_OUT) {
            continue;
        }
        let start = flat(first - from).norm();
        let direct = |a: &Position| {
            if crosses(*a, to, obstacle, BLOCK_KEEPS_OUT) {
                f32::INFINITY
            } else {
                flat(to - a).norm()
            }
        };
        let side = |j: usize| flat(corners[j % 4] - first).norm() + direct(&corners[j % 4]);
        let rest = direct(first).min(side(i + 1)).min(side(i + 3));
        if start + rest < best.0 {
            best = (start + rest, *first);
        }
    }
    best
}

fn inside(p: Position, obstacle: Position, half: [f32; 2]) -> bool {
    (p.x - obstacle.x).abs() < half[0] && (p.y - obstacle.y).abs() < half[1]
}

/// Whether the way from `a` to `b` crosses what is kept free; where it starts does not count.
fn crosses(a: Position, b: Position, obstacle: Position, half: [f32; 2]) -> bool {
    let half = half.map(|h| h - 0.001);
    let depth =
        |p: Position| (half[0] - (p.x - obstacle.x).abs()).min(half[1] - (p.y - obstacle.y).abs());
    let start = depth(a).max(0.0);
    (1..=40).any(|i| depth(a + (b - a) * (i as f32 / 40.0)) > start)
}

#[test]
fn a_hand_that_presses_on_the_obstacle_slides_along_it() {
    // In MuJoCo it moves by 3.0, 8.1, 32.8 and 6.4 mm per step, and with friction 1 not at all here.
    for (action, range) in [
        ([1.0, 0.2, 0.0, 0.0], 2.0..5.0),
        ([1.0, 0.5, 0.0, 0.0], 6.0..16.0),
        ([1.0, 0.0, 1.0, 0.0], 25.0..35.0),
        ([1.0, 0.0, 0.5, 0.0], 4.0..20.0),
    ] {
        let mut stand = obstacle_push();
        let block = Position::new(1.5, 0.7835, 0.42489);
        stand.env.arrange(Layout::new([block], [block]), &mut stand.observation).unwrap();
        stand.repeat(3, action);
        let before = stand.scene.gripper;
        stand.repeat(2, action);
        let moved = (stand.scene.gripper - before).yz().norm() / 2.0 * 1000.0;
        println!("obstacle-push: {action:?} moves a hand by {moved} mm per step");
        assert!(range.contains(&moved), "{action:?}: {moved} mm per step");
    }
}

#[test]
fn neither_hand_nor_block_passes_through_the_obstacle() {
    for aside in [-0.06, -0.03, 0.0, 0.015, 0.045] {
        let mut stand = obstacle_push();
        let block = Position::new(1.463, 0.7491, 0.42489);
        stand.env.arrange(Layout::new([block], [block]), &mut stand.observation).unwrap();
        let obstacle = obstacle(&stand.observation).x;
        // The hand from one side.
        stand.repeat(1, [0.0, aside / 0.032, 0.0, 0.0]);
        for _ in 0..20 {
            stand.step([1.0, 0.0, 0.0, 0.0]);
            let hand = stand.scene.gripper;
            let is_beside = (hand.y - 0.7491).abs() > 0.04 + 0.0149 - 0.002;
            assert!(is_beside || hand.x < obstacle - 0.0235 + 0.004, "{aside}: hand at {hand}");
        }
    }
    for aside in [-0.02, 0.0, 0.01] {
        let mut stand = obstacle_push();
        let block = Position::new(1.483, 0.7491 + aside, 0.42489);
        stand.env.arrange(Layout::new([block], [block]), &mut stand.observation).unwrap();
        let obstacle = obstacle(&stand.observation).x;
        // The block from the other.
        stand.go_to(Position::new(1.42, 0.7491, 0.51), 0.0);
        stand.go_to(Position::new(1.54, 0.7491, 0.51), 0.0);
        stand.go_to(Position::new(1.54, 0.7491, PUSH_HEIGHT), 0.0);
        for _ in 0..20 {
            stand.step([-1.0, 0.0, 0.0, 0.0]);
            let block = stand.block();
            assert!(block.x > obstacle + 0.035 - 0.004, "{aside}: block at {block}");
        }
        assert!(stand.block().x < obstacle + 0.05, "{aside}: block at {}", stand.block());
    }
}
