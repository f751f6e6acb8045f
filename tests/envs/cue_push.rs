//! The cue and the cylinder of `CuePush`.

use crate::support::{Stand, at_height, flat, random_action, seen_clearly, solved};
use nalgebra::Vector3;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::Env as _;
use rher_core::goal::Position;
use rher_envs::tasks::CuePush;
use rher_envs::{ACTION_WIDTH, Layout, OptionValue, Options, Simulated, Simulation, Task};

/// Height of the tip at which it pushes, in meters.
const PUSH_HEIGHT: f32 = 0.41;

/// Height at which it passes over the cylinder, in meters.
const PASS_HEIGHT: f32 = 0.445;

/// How far an action of 1 moves the cue in a step, in meters.
const MOVES_BY: f32 = 0.0195;

/// From the middle of the cue to that of a cylinder that it touches, in meters.
const TOUCHING: f32 = 0.03;

fn cue_push() -> Stand<Simulation<CuePush, 1>> {
    Stand::new(Simulation::new())
}

fn clear_cue_push() -> Stand<Simulation<CuePush, 1>> {
    Stand::new(Simulation::with(&seen_clearly(Task::CUE_PUSH)).unwrap())
}

#[test]
fn a_controller_pushes_with_the_cue() {
    let solved = solved(cue_push, || {
        let mut controller = Controller::default();
        move |stand: &Stand<_>, target| controller.act(stand, target)
    });
    assert!(solved >= 98, "{solved} of 100");
}

/// Over the cylinder to the side away from the target, down, and on to the target.
#[derive(Default)]
struct Controller {
    phase: Phase,
    /// Where cue and cylinder are believed to be; what is seen is noisy and late.
    tip: Option<Position>,
    cylinder: Option<Position>,
    /// What the last action should have moved the cue by.
    moved: Vector3<f32>,
}

#[derive(Default)]
enum Phase {
    #[default]
    Over,
    Down,
    Push,
    Done,
}

impl Controller {
    fn act<E: Simulated<1>>(&mut self, stand: &Stand<E>, target: Position) -> [f32; ACTION_WIDTH] {
        let [x, y, z, _] = self.choose(stand, target).map(|number| number.clamp(-1.0, 1.0));
        self.moved = Vector3::new(x, y, z) * MOVES_BY;
        [x, y, z, 0.0]
    }

    fn choose<E: Simulated<1>>(
        &mut self,
        stand: &Stand<E>,
        target: Position,
    ) -> [f32; ACTION_WIDTH] {
        let moved = self.moved;
        let touches = match (self.tip, self.cylinder) {
            (Some(tip), Some(cylinder)) => {
                tip.z < PUSH_HEIGHT + 0.01 && flat(cylinder - tip).norm() < TOUCHING + 0.004
            }
            _ => false,
        };
        let (seen_tip, seen) = (stand.scene.gripper + moved, stand.block());
        let tip = self.tip.map_or(seen_tip, |tip| nalgebra::center(&(tip + moved), &seen_tip));
        let carried = if touches { flat(moved) } else { Vector3::zeros() };
        let cylinder = self
            .cylinder
            .map_or(seen, |cylinder| nalgebra::center(&(cylinder + carried), &(seen + carried)));
        (self.tip, self.cylinder) = (Some(tip), Some(cylinder));

        let way = flat(target - cylinder);
        let ahead = way.try_normalize(1e-6).unwrap_or_default();
        let behind = cylinder - ahead * (TOUCHING + 0.008);
        let offset = flat(tip - cylinder);
        let aside = offset - ahead * offset.dot(&ahead);
        match self.phase {
            Phase::Over if flat(behind - tip).norm() < 0.006 => self.phase = Phase::Down,
            Phase::Down if tip.z < PUSH_HEIGHT + 0.008 => self.phase = Phase::Push,
            Phase::Push if way.norm() < 0.006 => self.phase = Phase::Done,
            Phase::Push if aside.norm() > 0.015 => self.phase = Phase::Over,
            _ => {}
        }
        let towards = |place: Position| {
            let [x, y, z]: [f32; 3] = ((place - tip) / MOVES_BY).into();
            [x, y, z, 0.0]
        };
        match self.phase {
            Phase::Over if tip.z < PASS_HEIGHT - 0.006 && offset.norm() < TOUCHING + 0.015 => {
                [0.0, 0.0, 1.0, 0.0]
            }
            Phase::Over => towards(at_height(behind, PASS_HEIGHT)),
            Phase::Down => towards(at_height(behind, PUSH_HEIGHT)),
            Phase::Push => {
                let push = ahead * (way.norm() * 20.0).clamp(0.12, 0.8) - aside * 25.0;
                [push.x, push.y, (PUSH_HEIGHT - tip.z) * 20.0, 0.0]
            }
            Phase::Done => [0.0; 4],
        }
    }
}

#[test]
fn the_cue_stays_in_its_workspace() {
    let mut cue = clear_cue_push();
    for (x, y, z) in [(1.0, 1.0, 1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, -1.0)] {
        cue.repeat(15, [x, y, z, 0.0]);
        let tip = cue.scene.gripper;
        assert!((tip.x - 1.3).abs() < 0.047 && (tip.y - 0.7491).abs() < 0.072, "{tip}");
        assert!((0.402..0.475).contains(&tip.z), "{tip}");
    }
}

#[test]
fn an_episode_begins_unsolved_with_room_for_the_cue() {
    let mut cue = clear_cue_push();
    for seed in 0..1000 {
        let target = cue.reset(seed).objects()[0];
        let start = cue.block();
        assert!((target - start).norm() > 0.0399, "{seed}");
        assert!((start.x - 1.3).abs() < 0.0151 && (start.y - 0.7491).abs() < 0.0401, "{start}");
    }
}

#[test]
fn the_camera_is_noisy_and_late_and_the_truth_is_told() {
    let (mut cue, mut clear) = (cue_push(), clear_cue_push());
    let mut squares = 0.0;
    let mut before = None;
    for seed in 0..50 {
        cue.reset(seed);
        clear.reset(seed);
        assert_eq!(clear.env.truth().unwrap().0, clear.scene);
        for step in 0..20 {
            let action = [if step < 10 { 1.0 } else { -1.0 }, 0.4, -0.3, 0.0];
            before = Some(clear.scene.gripper).or(before);
            cue.step(action);
            clear.step(action);
            assert_eq!(cue.env.truth().unwrap().0, clear.scene, "{seed} {step}");
            let error = cue.scene.gripper - before.unwrap();
            squares += error.norm_squared() / 3.0;
        }
    }
    let deviation = (squares / 1000.0_f32).sqrt();
    assert!((deviation - 0.001).abs() < 1e-4, "{deviation} m of noise, a step late");
}

#[test]
fn goals_are_compared_with_what_is_seen() {
    let mut cue = cue_push();
    cue.reset(3);
    cue.step([0.0; 4]);
    assert_eq!(cue.observation[..3], *cue.scene.gripper.coords.as_slice());
    assert_eq!(cue.observation[3..6], *cue.block().coords.as_slice());
    assert_ne!(cue.env.truth().unwrap().0, cue.scene);
}

#[test]
fn the_cue_does_not_pass_through_the_cylinder() {
    for aside in [-0.02, -0.01, 0.0, 0.005, 0.015] {
        let mut cue = clear_cue_push();
        let cylinder = Position::new(1.3 + aside, 0.7491, 0.415);
        let layout = Layout::new([cylinder], [cylinder]);
        cue.env.arrange(layout, &mut cue.observation).unwrap();
        cue.repeat(5, [0.0, -1.0, 0.0, 0.0]);
        cue.repeat(5, [0.0, 0.0, -1.0, 0.0]);
        for _ in 0..15 {
            cue.step([0.0, 1.0, 0.0, 0.0]);
            let apart = flat(cue.block() - cue.scene.gripper).norm();
            assert!(apart > TOUCHING - 0.003, "{aside}: {apart} m apart");
        }
    }
}

#[test]
fn the_cylinder_stays_upright_whatever_the_cue_does() {
    let mut cue = clear_cue_push();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for seed in 0..200 {
        cue.reset(seed);
        for _ in 0..5 {
            cue.repeat(4, random_action(&mut rng));
            assert!(cue.block().z < 0.42, "{seed}: its middle is at {}", cue.block());
        }
    }
}

#[test]
fn noise_and_delay_can_be_set() {
    let mut options = Options::of(Task::CUE_PUSH.options());
    options.task.0.insert("noise".to_owned(), OptionValue::Number(0.5));
    let error = Simulation::<CuePush, 1>::with(&options).err().unwrap();
    assert_eq!(error.to_string(), "`task.noise` is 0.5, expected a number from 0 to 0.02");
    options.task.0.insert("noise".to_owned(), OptionValue::Count(0));
    assert!(Simulation::<CuePush, 1>::with(&options).is_ok());
}

#[test]
fn a_cylinder_that_was_let_go_only_becomes_slower() {
    for (x, y) in [(1.0, 0.0), (0.4, 0.0), (-0.7, 0.0)] {
        let mut cue = clear_cue_push();
        let cylinder = Position::new(1.3, 0.7491, 0.415);
        cue.env.arrange(Layout::new([cylinder], [cylinder]), &mut cue.observation).unwrap();
        cue.repeat(3, [-f32::signum(x), y, 0.0, 0.0]);
        cue.repeat(5, [0.0, 0.0, -1.0, 0.0]);
        cue.repeat(3, [x, y, 0.0, 0.0]);
        cue.step([0.0; 4]);
        let mut before = f32::INFINITY;
        for _ in 0..20 {
            let start = cue.block();
            cue.step([-x, 0.0, 1.0, 0.0]);
            let moved = (cue.block() - start).norm();
            assert!(moved < before + 1e-5, "{x}: {before} m in a step, then {moved} m");
            before = moved;
        }
        assert!(before < 1e-4, "{x}: still moves by {before} m in a step");
    }
}
