//! Two and three blocks: controllers written by hand push and stack them, and stacks stand.

use crate::scripted::PUSH_HEIGHT;
use crate::support::{FINGERTIP, HALF_BLOCK, Stand, at_height, flat, is_met, towards};
use nalgebra::Vector3;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rher_core::goal::{Achieved, Position, Scene};
use rher_envs::tasks::{DPush, Stack, TPush, TStack};
use rher_envs::{ACTION_WIDTH, Simulated, Simulation};
use std::f32::consts::PI;

/// How near to its target a block is left alone, in meters.
const CLOSE_ENOUGH: f32 = 0.025;

/// Height at which the hand passes over a block, in meters.
const PASS_HEIGHT: f32 = 0.48;

/// How near to other blocks the hand travels below their tops, its fingers closed or open, in
/// meters.
const CLOSED_WIDTH: f32 = 0.05;
const OPEN_WIDTH: f32 = 0.08;

/// By how much it is as if a way were longer, in meters: one in two legs, one past another block,
/// one that begins where the fingers do not fit, one that ends where another block has to pass.
const DETOUR: f32 = 0.4;
const BLOCKED: f32 = 0.6;
const TIGHT: f32 = 1.0;
const BARRED: f32 = 0.1;

/// How far fingers open to grip a block, in meters.
const WIDE_ENOUGH: f32 = 0.033;

/// What the fingers do to grip.
const CLOSE: f32 = -1.0;

#[test]
fn a_controller_pushes_two_blocks() {
    check(Simulation::<DPush, 2>::new(), || {
        let mut pushing = Pushing::default();
        move |_: &[f32], scene: &Scene<_>, targets: &[Position; _]| pushing.act(scene, targets)
    });
}

#[test]
fn a_controller_pushes_three_blocks() {
    check(Simulation::<TPush, 3>::new(), || {
        let mut pushing = Pushing::default();
        move |_: &[f32], scene: &Scene<_>, targets: &[Position; _]| pushing.act(scene, targets)
    });
}

#[test]
fn a_controller_stacks_two_blocks() {
    check(Simulation::<Stack, 2>::new(), || {
        let mut state = Stacking::new();
        move |seen: &[f32], scene: &Scene<2>, targets: &[Position; 2]| {
            state.act(seen[3], scene, targets)
        }
    });
}

#[test]
fn a_controller_stacks_three_blocks() {
    check(Simulation::<TStack, 3>::new(), || {
        let mut state = Stacking::new();
        move |seen: &[f32], scene: &Scene<3>, targets: &[Position; 3]| {
            state.act(seen[0], scene, targets)
        }
    });
}

#[test]
fn released_stacks_stand() {
    stand_still(Simulation::<Stack, 2>::new(), 3);
    stand_still(Simulation::<TStack, 3>::new(), 0);
}

/// Stacks blocks, lets go, and watches them for 10 seconds; `fingers` is where the observation has
/// the opening.
fn stand_still<const N: usize>(env: impl Simulated<N>, fingers: usize) {
    let (mut drift, mut speed) = (0.0_f32, 0.0_f32);
    let mut stand = Stand::new(env);
    let mut stacks = 0;
    for seed in 0..20 {
        let desired = stand.reset(seed);
        let mut stacking = Stacking::new();
        for _ in 0..stand.env.spec().episode_steps {
            let opening = stand.observation[fingers];
            let action = stacking.act(opening, &stand.scene, desired.objects());
            stand.step(action);
        }
        if !is_met(&stand.env, Achieved(stand.scene), &desired) {
            continue;
        }
        stacks += 1;
        // Up, and a second for the stack to stop swaying.
        stand.repeat(5, [0.0, 0.0, 1.0, 0.0]);
        stand.repeat(25, [0.0; 4]);
        let released = stand.scene.objects;
        for _ in 0..250 {
            let before = stand.scene.objects;
            stand.step([0.0; 4]);
            for ((now, before), released) in stand.scene.objects.iter().zip(before).zip(released) {
                drift = drift.max((now - released).norm());
                speed = speed.max((now - before).norm() / 0.04);
            }
        }
    }
    println!("stacks of {N}, {stacks} of them: drift {drift} m in 10 s, at most {speed} m/s");
    assert!(stacks >= 15 && drift < 0.001 && speed < 0.002, "{N}: {drift} m, {speed} m/s");
}

#[test]
fn blocks_that_fall_onto_each_other_gain_no_energy() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (mut gained, mut above_start) = (0.0_f32, f32::NEG_INFINITY);
    for _ in 0..50 {
        let mut stand = Stand::new(Simulation::<DPush, 2>::new());
        let mut offset = |spread: f32| rng.random_range(-spread..spread);
        let foot = Position::new(1.45 + offset(0.02), 0.9 + offset(0.02), 0.46 + offset(0.03));
        let on_top = foot + Vector3::new(offset(0.04), offset(0.04), 0.08 + offset(0.02));
        stand.arrange([foot, on_top]);
        let start = energy_of_two_blocks(&stand.observation, &stand.scene);
        let mut least = start;
        for _ in 0..100 {
            stand.step([0.0; 4]);
            let energy = energy_of_two_blocks(&stand.observation, &stand.scene);
            above_start = above_start.max(energy - start);
            gained = gained.max(energy - least);
            least = least.min(energy);
        }
    }
    println!("two blocks that fall: {above_start} J over the start, {gained} J over the least");
    // What landed a few millimeters deep is lifted out again.
    assert!(above_start < 1e-3 && gained < 0.1, "{above_start} J, {gained} J");
}

/// In joules, above the table's top.
fn energy_of_two_blocks(observation: &[f32], scene: &Scene<2>) -> f32 {
    const MASS: f32 = 2.0;
    const INERTIA: f32 = MASS * 4.0 * HALF_BLOCK * HALF_BLOCK / 6.0;
    let vector = |at: usize| Vector3::from_column_slice(&observation[at..at + 3]) / 0.04;
    let hand = vector(35);
    [5, 20]
        .into_iter()
        .zip(scene.objects)
        .map(|(at, block)| {
            let (velocity, spin) = (vector(at + 9) + hand, vector(at + 12));
            MASS * 9.81 * (block.z - 0.4)
                + MASS / 2.0 * velocity.norm_squared()
                + INERTIA / 2.0 * spin.norm_squared()
        })
        .sum()
}

/// Asks a controller to meet the goal at the last step of 98 episodes of 100.
fn check<const N: usize, C>(env: impl Simulated<N>, controller: impl Fn() -> C)
where
    C: FnMut(&[f32], &Scene<N>, &[Position; N]) -> [f32; ACTION_WIDTH],
{
    let mut stand = Stand::new(env);
    let failed: Vec<u64> = (0..100)
        .filter(|seed| {
            let desired = stand.reset(*seed);
            let mut act = controller();
            for _ in 0..stand.env.spec().episode_steps {
                let action = act(&stand.observation, &stand.scene, desired.objects());
                stand.step(action);
            }
            !is_met(&stand.env, Achieved(stand.scene), &desired)
        })
        .collect();
    let name = &stand.env.spec().name;
    println!("{name}: a controller succeeds from {} of 100 starts", 100 - failed.len());
    assert!(failed.len() <= 2, "{name}: failed from {failed:?}");
}

/// Pushes blocks one by one: each time the one that is easiest to push.
#[derive(Default)]
struct Pushing {
    shove: Option<Shove>,
}

/// To bring a block to a place, in a straight line.
#[derive(Clone, Copy, Debug)]
struct Shove {
    block: usize,
    to: Position,
}

impl Pushing {
    fn act<const N: usize>(
        &mut self,
        scene: &Scene<N>,
        targets: &[Position; N],
    ) -> [f32; ACTION_WIDTH] {
        let on = self.shove.filter(|push| {
            push.is_left(scene)
                && (scene.gripper.z < PASS_HEIGHT - 0.02
                    || push.is_free(scene.objects[push.block], scene))
        });
        self.shove = on.or_else(|| Shove::easiest(scene, targets));
        self.shove.map_or([0.0; 4], |push| push.act(scene))
    }
}

impl Shove {
    /// Of all blocks that are not at their targets, straight there or by way of another place.
    fn easiest<const N: usize>(scene: &Scene<N>, targets: &[Position; N]) -> Option<Self> {
        let mut easiest = (f32::INFINITY, None);
        for (block, target) in targets.iter().enumerate() {
            let straight = Self { block, to: *target };
            if !straight.is_left(scene) {
                continue;
            }
            let detours = ring(scene.objects[block]).map(|to| Self { block, to });
            for shove in std::iter::once(straight).chain(detours) {
                let from = scene.objects[block];
                let mut effort =
                    flat(shove.behind(from) - scene.gripper).norm() + shove.effort(from, scene);
                if shove.to != *target {
                    effort += DETOUR + straight.effort(shove.to, scene);
                }
                // What still has to pass by here goes first.
                let barred = (0..N).any(|other| {
                    let later = Self { block: other, to: targets[other] };
                    other != block
                        && later.is_left(scene)
                        && distance_to_way(shove.to, scene.objects[other], later.to) < 0.06
                });
                effort += if barred { BARRED } else { 0.0 };
                if effort < easiest.0 {
                    easiest = (effort, Some(shove));
                }
            }
        }
        easiest.1
    }

    /// Whether the block is not there yet.
    fn is_left<const N: usize>(self, scene: &Scene<N>) -> bool {
        flat(self.to - scene.objects[self.block]).norm() > CLOSE_ENOUGH
    }

    /// Where the hand starts if the block is at `from`.
    fn behind(self, from: Position) -> Position {
        let ahead = flat(self.to - from).normalize();
        // Further away where the corners of block and fingers meet.
        at_height(from - ahead * (0.052 + 0.03 * (ahead.x * ahead.y).abs()), PUSH_HEIGHT)
    }

    /// Whether there is room for the fingers behind the block.
    fn is_free<const N: usize>(self, from: Position, scene: &Scene<N>) -> bool {
        let behind = self.behind(from);
        self.others(scene).all(|other| flat(other - behind).norm() > 0.052)
    }

    fn others<const N: usize>(self, scene: &Scene<N>) -> impl Iterator<Item = Position> {
        (0..N).filter(move |i| *i != self.block).map(|i| scene.objects[i])
    }

    /// Meters to go, and more for what is in the way.
    fn effort<const N: usize>(self, from: Position, scene: &Scene<N>) -> f32 {
        // What the block leaves behind is not in its way.
        let blocked = self.others(scene).any(|other| {
            let nearest = distance_to_way(other, from, self.to);
            nearest < 0.055 && nearest < flat(other - from).norm() - 0.004
        });
        flat(self.to - from).norm()
            + if self.is_free(from, scene) { 0.0 } else { TIGHT }
            + if blocked { BLOCKED } else { 0.0 }
    }

    /// Around the block to the side away from the target, down, and on to the target.
    fn act<const N: usize>(self, scene: &Scene<N>) -> [f32; ACTION_WIDTH] {
        let (hand, block) = (scene.gripper, scene.objects[self.block]);
        let way = flat(self.to - block);
        let ahead = way.normalize();
        let behind = self.behind(block);
        let offset = flat(hand - block);
        let along = offset.dot(&ahead);
        let aside = (offset - ahead * along).norm();

        if along < -0.03 && aside < 0.012 && hand.z < PASS_HEIGHT - 0.03 {
            // Slower the nearer, since the block glides on.
            let speed = (way.norm() * 15.0).clamp(0.3, 1.0);
            let centered = block - ahead * 0.035;
            let correction = flat(centered - hand) * 8.0;
            let correction = correction - ahead * correction.dot(&ahead);
            let push = ahead * speed + correction;
            return [push.x, push.y, (PUSH_HEIGHT - hand.z) * 20.0, 0.0];
        }
        let next = fly(hand, behind, FINGERTIP + 0.01, CLOSED_WIDTH, scene.objects.into_iter());
        towards(next, hand, 0.0)
    }
}

/// Places around another one.
#[expect(clippy::disallowed_methods, reason = "a script acts by it, which is judged by success")]
fn ring(center: Position) -> impl Iterator<Item = Position> {
    [0.06, 0.1, 0.14].into_iter().flat_map(move |radius| {
        (0..16_u8).map(move |i| {
            let angle = f32::from(i) * PI / 8.0;
            center + Vector3::new(angle.cos(), angle.sin(), 0.0) * radius
        })
    })
}

/// How near a straight way along the table comes to a place, in meters.
fn distance_to_way(place: Position, from: Position, to: Position) -> f32 {
    let (place, way) = (flat(place - from), flat(to - from));
    let along = (place.dot(&way) / way.norm_squared().max(1e-9)).clamp(0.0, 1.0);
    (place - way * along).norm()
}

/// Where a controller is in building a stack, block by block.
struct Stacking {
    block: usize,
    phase: Phase,
    steps: usize,
    opening: f32,
    shove: Option<Shove>,
}

/// What is done with one block.
#[derive(Clone, Copy)]
enum Phase {
    /// Over it and down, fingers open.
    Approach,
    Grip,
    /// Over its target and down.
    Carry,
    Release,
}

impl Stacking {
    fn new() -> Self {
        Self { block: 0, phase: Phase::Approach, steps: 0, opening: 0.0, shove: None }
    }

    fn act<const N: usize>(
        &mut self,
        opening: f32,
        scene: &Scene<N>,
        targets: &[Position; N],
    ) -> [f32; ACTION_WIDTH] {
        if let Some(action) = self.make_room(scene, targets[0]) {
            return action;
        }
        let hand = scene.gripper;
        // No wider than it takes: there may be another block beside this one.
        let open = 1.2 * (WIDE_ENOUGH - opening) - 1.5 * (opening - self.opening);
        self.opening = opening;
        loop {
            let Some(block) = scene.objects.get(self.block) else {
                return [0.0, 0.0, 0.0, open];
            };
            let target = targets[self.block];
            let others = || (0..N).filter(|i| *i != self.block).map(|i| scene.objects[i]);
            let (done, action) = match self.phase {
                Phase::Approach => {
                    let mut over =
                        fly(hand, *block, FINGERTIP + 0.005, OPEN_WIDTH, scene.objects.into_iter());
                    if opening < 0.029 {
                        over.z = over.z.max(block.z + HALF_BLOCK + FINGERTIP + 0.003);
                    }
                    let left = flat(block - hand).norm();
                    (left < 0.01 && hand.z < block.z + 0.01, towards(over, hand, open))
                }
                Phase::Grip => (self.steps >= 3, [0.0, 0.0, 0.0, CLOSE]),
                Phase::Carry => {
                    let on = hand + (target - block);
                    let low = hand.z - block.z + HALF_BLOCK + 0.004;
                    let over = fly(hand, on, low, OPEN_WIDTH, others());
                    let left = flat(target - block).norm();
                    (left < 0.012 && block.z < target.z + 0.005, towards(over, hand, CLOSE))
                }
                Phase::Release => (self.steps >= 2, [0.0, 0.0, 0.0, open]),
            };
            if !done {
                self.steps += 1;
                return action;
            }
            self.steps = 0;
            self.phase = match self.phase {
                Phase::Approach => Phase::Grip,
                Phase::Grip => Phase::Carry,
                Phase::Carry => Phase::Release,
                Phase::Release => {
                    self.block += 1;
                    Phase::Approach
                }
            };
        }
    }

    /// Shoves away what is where the first block should go.
    #[expect(
        clippy::disallowed_methods,
        reason = "a script acts by it, which is judged by success"
    )]
    fn make_room<const N: usize>(
        &mut self,
        scene: &Scene<N>,
        foot: Position,
    ) -> Option<[f32; ACTION_WIDTH]> {
        if self.block > 0 || !matches!(self.phase, Phase::Approach) {
            return None;
        }
        let in_the_way = (1..N).find(|i| flat(scene.objects[*i] - foot).norm() < 0.085)?;
        let shove = self.shove.filter(|shove| shove.is_left(scene)).or_else(|| {
            (0..16_u8)
                .map(|i| {
                    let angle = f32::from(i) * PI / 8.0;
                    let away = Vector3::new(angle.cos(), angle.sin(), 0.0) * 0.125;
                    Shove { block: in_the_way, to: foot + away }
                })
                .filter(|s| s.others(scene).all(|o| flat(o - s.to).norm() > 0.08))
                .min_by(|a, b| {
                    let from = scene.objects[in_the_way];
                    a.effort(from, scene).total_cmp(&b.effort(from, scene))
                })
        })?;
        self.shove = Some(shove);
        Some(shove.act(scene))
    }
}

/// The next place on the way to `goal`, with `low` meters below the hand clear of blocks.
fn fly(
    hand: Position,
    goal: Position,
    low: f32,
    width: f32,
    blocks: impl Iterator<Item = Position>,
) -> Position {
    let left = flat(goal - hand).norm();
    // Open fingers stand closer to the block along y.
    if (goal.x - hand.x).abs() < 0.015 && (goal.y - hand.y).abs() < 0.006 {
        return goal;
    }
    let near = hand + flat(goal - hand) * (0.05 / left).min(1.0);
    let (mut cruise, mut must) = (goal.z, 0.0_f32);
    for block in blocks {
        let above = block.z + HALF_BLOCK + low;
        if distance_to_way(block, hand, goal) < width {
            cruise = cruise.max(above);
        }
        if distance_to_way(block, hand, near) < width {
            must = must.max(above);
        }
    }
    let ahead = if hand.z < must - 0.008 { hand } else { goal };
    at_height(ahead, cruise)
}
