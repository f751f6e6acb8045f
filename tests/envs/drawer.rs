//! The drawer: what it withstands, and controllers written by hand that open and empty it.

use crate::support::{
    FINGERTIP, HALF_BLOCK, Stand, at_height, flat, is_met, random_action, towards,
};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::goal::{Achieved, Position, Scene};
use rher_envs::tasks::{Drawer, DrawerBox};
use rher_envs::{ACTION_WIDTH, Simulated, Simulation};

/// How far the drawer opens, in meters.
const TRAVEL: f32 = 0.2;

/// Where the handle of the closed drawer is in `drawer`.
const HANDLE: Position = Position::new(1.376, 0.63, 0.45);

/// From the handle to the front of the drawer, in meters.
const FRONT: f32 = 0.024;

/// Height at which the hand passes over the handle, in meters.
const PASS_HEIGHT: f32 = 0.5;

/// How far fingers open to grip the block, in meters.
const WIDE_ENOUGH: f32 = 0.035;

/// What the fingers do to grip.
const CLOSE: f32 = -1.0;

#[test]
fn a_controller_opens_the_drawer() {
    check(Simulation::<Drawer, 1>::new(), || {
        |stand: &Stand<_, 1>, targets: &[Position; 1]| {
            open(stand.scene.gripper, stand.scene.objects[0], targets[0])
        }
    });
}

#[test]
fn a_controller_puts_the_block_on_top_of_the_cabinet() {
    check(Simulation::<DrawerBox, 2>::new(), || {
        let mut emptying = Emptying { phase: Phase::Open, steps: 0, opening: 0.0 };
        move |stand: &Stand<_, 2>, targets: &[Position; 2]| {
            emptying.act(stand.observation[9], &stand.scene, targets)
        }
    });
}

#[test]
fn the_drawer_stops_at_its_limits_and_stays_where_it_is_left() {
    let mut stand = hooked();
    stand.repeat(20, [-1.0, 0.0, 0.0, 0.0]);
    let opened = HANDLE.x - stand.scene.objects[0].x;
    assert!((opened - TRAVEL).abs() < 0.002, "opened by {opened} m");
    stand.repeat(1, [0.0; 4]);
    let left = stand.scene.objects[0];
    stand.repeat(10, [0.0, 0.0, 1.0, 0.0]);
    stand.repeat(100, [0.0; 4]);
    let moved = (stand.scene.objects[0] - left).norm();
    println!("drawer: pulled open by {opened} m of {TRAVEL}, moves by {moved} m when left alone");
    assert!(moved < 0.001, "moved by {moved} m");

    let mut stand = hooked();
    stand.repeat(3, [-1.0, 0.0, 0.0, 0.0]);
    stand.repeat(20, [1.0, 0.0, 0.0, 0.0]);
    let opened = HANDLE.x - stand.scene.objects[0].x;
    println!("drawer: pushed shut to {opened} m");
    assert!(opened.abs() < 0.002, "{opened} m open");
}

#[test]
fn a_half_open_drawer_stops_soon() {
    let mut stand = hooked();
    stand.repeat(4, [-1.0, 0.0, 0.0, 0.0]);
    let let_go = stand.scene.objects[0];
    stand.repeat(25, [0.0, 0.0, 1.0, 0.0]);
    let coasts = (stand.scene.objects[0] - let_go).norm();
    stand.repeat(100, [0.0; 4]);
    let creeps = (stand.scene.objects[0] - let_go).norm() - coasts;
    println!("drawer: let go at full speed, coasts {coasts} m, creeps {creeps} m in 4 s");
    assert!(coasts < 0.03 && creeps.abs() < 1e-4, "coasts {coasts} m, creeps {creeps} m");
}

#[test]
fn a_gripper_does_not_bend_the_drawer() {
    let mut worst = 0.0_f32;
    for opening in [0, 4] {
        for push in [[0.0, 1.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.3, 1.0, -1.0, 0.0]] {
            let mut stand = hooked();
            stand.repeat(opening, [-1.0, 0.0, 0.0, 0.0]);
            for _ in 0..30 {
                stand.step(push);
                let off = stand.scene.objects[0] - HANDLE;
                worst = worst.max(off.y.abs()).max(off.z.abs());
            }
        }
        // From above, on the bar of the handle.
        let mut stand = Stand::new(Simulation::<Drawer, 1>::new());
        let bar = at_height(HANDLE, PASS_HEIGHT + 0.02) - nalgebra::Vector3::x() * 0.028;
        stand.go_to(bar, 0.0);
        for _ in 0..30 {
            stand.step([0.0, 0.0, -1.0, 0.0]);
            let off = stand.scene.objects[0] - HANDLE;
            worst = worst.max(off.y.abs()).max(off.z.abs());
            let tip = stand.scene.gripper.z - FINGERTIP;
            assert!(tip > 0.452, "fingertip at {tip} m, in the handle");
        }
    }
    println!("drawer: bent by {worst} m at most");
    assert!(worst < 1e-5, "bent by {worst} m");
}

#[test]
fn nothing_passes_through_the_front_of_the_drawer() {
    let mut deepest = 0.0_f32;
    for aside in [0.0, 0.05, -0.08] {
        for distance in [0.1, 0.11, 0.12, 0.13] {
            let mut stand = Stand::new(Simulation::<Drawer, 1>::new());
            let start = HANDLE - nalgebra::Vector3::new(distance, aside, -0.03);
            stand.go_to(at_height(start, PASS_HEIGHT + 0.1), 0.0);
            stand.go_to(start, 0.0);
            for _ in 0..12 {
                stand.step([1.0, 0.0, 0.0, 0.0]);
                let inside = stand.scene.gripper.x + 0.0135 - (HANDLE.x + FRONT);
                deepest = deepest.max(inside);
            }
        }
    }
    println!("drawer: fingers at full speed get {deepest} m into its front");
    assert!(deepest < 0.004, "{deepest} m behind the front");
}

#[test]
fn the_block_moves_with_the_drawer() {
    let mut worst = 0.0_f32;
    for seed in 0..10 {
        let mut stand = Stand::new(Simulation::<DrawerBox, 2>::new());
        let targets = *stand.reset(seed).objects();
        let before = stand.scene.objects[1] - stand.scene.objects[0];
        for _ in 0..30 {
            let mut action = open(stand.scene.gripper, stand.scene.objects[0], targets[0]);
            action[3] = CLOSE;
            stand.step(action);
        }
        let slipped = (stand.scene.objects[1] - stand.scene.objects[0] - before).norm();
        worst = worst.max(slipped);
        assert!((stand.scene.objects[0] - targets[0]).norm() < 0.02, "{:?}", stand.scene);
    }
    println!("drawer-box: the block slips by {worst} m at most while the drawer is pulled");
    assert!(worst < 0.04, "slipped by {worst} m");
}

#[test]
fn the_block_stays_in_the_drawer_when_it_is_shoved_about() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for seed in 0..20 {
        let mut stand = Stand::new(Simulation::<DrawerBox, 2>::new());
        let targets = *stand.reset(seed).objects();
        for _ in 0..22 {
            let mut action = open(stand.scene.gripper, stand.scene.objects[0], targets[0]);
            action[3] = CLOSE;
            stand.step(action);
        }
        stand.repeat(5, [0.0, 0.0, 1.0, CLOSE]);
        let over = at_height(stand.scene.objects[1], 0.52);
        stand.go_to(over + nalgebra::Vector3::x() * 0.05, CLOSE);
        for step in 0..40 {
            let mut action = random_action(&mut rng).map(f32::signum);
            action[2] = if step < 8 { -1.0 } else { -0.2 };
            stand.step(action);
            let block = stand.scene.objects[1];
            let handle = stand.scene.objects[0];
            let offset = block - handle;
            // The bottom of the drawer is 5.5 cm below the handle.
            let fell = offset.z < -0.055 + HALF_BLOCK - 0.006;
            assert!(!fell, "seed {seed}, step {step}: {:?}", stand.scene);
        }
    }
}

/// A hand in the bow of the closed drawer's handle.
fn hooked() -> Stand<Simulation<Drawer, 1>> {
    let mut stand = Stand::new(Simulation::new());
    stand.go_to(at_height(HANDLE, PASS_HEIGHT), 0.0);
    stand.go_to(HANDLE, 0.0);
    stand
}

/// Asks a controller to meet the goal at the last step of 98 episodes of 100.
fn check<E: Simulated<N>, const N: usize, C>(env: E, controller: impl Fn() -> C)
where
    C: FnMut(&Stand<E, N>, &[Position; N]) -> [f32; ACTION_WIDTH],
{
    let mut stand = Stand::new(env);
    let failed: Vec<u64> = (0..100)
        .filter(|seed| {
            let desired = stand.reset(*seed);
            let mut act = controller();
            for _ in 0..stand.env.spec().episode_steps {
                let action = act(&stand, desired.objects());
                stand.step(action);
            }
            !is_met(&stand.env, Achieved(stand.scene), &desired)
        })
        .collect();
    let name = &stand.env.spec().name;
    println!("{name}: a controller succeeds from {} of 100 starts", 100 - failed.len());
    assert!(failed.len() <= 2, "{name}: failed from {failed:?}");
}

/// Over the handle, down into its bow, and along with it to the target.
fn open(hand: Position, handle: Position, target: Position) -> [f32; ACTION_WIDTH] {
    let aside = flat(handle - hand);
    let hooked = aside.norm() < 0.02 && hand.z < handle.z + 0.02;
    if hooked {
        let left = target.x - handle.x;
        let speed = if left.abs() < 0.003 { 0.0 } else { left * 20.0 };
        [speed, aside.y * 20.0, (handle.z - hand.z) * 20.0, 0.0]
    } else if aside.norm() < 0.008 {
        towards(handle, hand, 0.0)
    } else {
        towards(at_height(handle, PASS_HEIGHT), hand, 0.0)
    }
}

/// Where a controller is in emptying the drawer.
struct Emptying {
    phase: Phase,
    steps: usize,
    opening: f32,
}

#[derive(Clone, Copy)]
enum Phase {
    Open,
    /// Up, out of the handle.
    Leave,
    /// Over the block and down, fingers open.
    Approach,
    Grip,
    Lift,
    /// Over its target and down.
    Carry,
    Release,
}

impl Emptying {
    fn act(
        &mut self,
        opening: f32,
        scene: &Scene<2>,
        targets: &[Position; 2],
    ) -> [f32; ACTION_WIDTH] {
        let (hand, [handle, block], [pulled, top]) = (scene.gripper, scene.objects, *targets);
        let spread = 1.2 * (WIDE_ENOUGH - opening) - 1.5 * (opening - self.opening);
        self.opening = opening;
        loop {
            let (done, action, next) = match self.phase {
                Phase::Open => {
                    let mut action = open(hand, handle, pulled);
                    action[3] = CLOSE;
                    ((pulled - handle).norm() < 0.012, action, Phase::Leave)
                }
                Phase::Leave => {
                    let up = at_height(hand, PASS_HEIGHT + 0.01);
                    (hand.z > PASS_HEIGHT - 0.015, towards(up, hand, spread), Phase::Approach)
                }
                Phase::Approach => {
                    let ready = flat(block - hand).norm() < 0.008 && opening > 0.03;
                    let height = if ready { block.z + 0.025 } else { PASS_HEIGHT };
                    let to = towards(at_height(block, height), hand, spread);
                    (ready && hand.z < block.z + 0.034, to, Phase::Grip)
                }
                Phase::Grip => (self.steps >= 3, [0.0, 0.0, 0.0, CLOSE], Phase::Lift),
                Phase::Lift => {
                    let up = [0.0, 0.0, 1.0, CLOSE];
                    (block.z > 0.505, up, Phase::Carry)
                }
                Phase::Carry => {
                    let aside = flat(top - block).norm();
                    let height = if aside < 0.02 { 0.514 } else { 0.53 };
                    let to = hand + (at_height(top, height) - block);
                    let done = aside < 0.015 && block.z < 0.518;
                    (done, towards(to, hand, CLOSE), Phase::Release)
                }
                Phase::Release => (false, [0.0, 0.0, 0.0, spread], Phase::Release),
            };
            if !done {
                self.steps += 1;
                return action;
            }
            (self.phase, self.steps) = (next, 0);
        }
    }
}
