//! How far the physics here is from recorded episodes of the real Fetch environments.

use nalgebra::Vector3;
use rher_core::goal::Position;
use rher_envs::{EnvVisitor, Layout, Simulated, Task};
use std::collections::BTreeMap;

const REACH: &str = include_str!("../data/fetch_reach.csv");
const PUSH: &str = include_str!("../data/fetch_push.csv");
const PICK: &str = include_str!("../data/fetch_pick.csv");

#[test]
fn the_hand_moves_as_in_fetch() {
    for (task, csv) in [(Task::PUSH, PUSH), (Task::PICK, PICK)] {
        let replays = task.visit(Replay(read(csv)));
        let errors = || replays.iter().flat_map(|replay| &replay.hand_errors);
        let rms = Vector3::from_fn(|axis, _| root_mean_square(errors().map(|e| e[axis])));
        assert!(rms.max() < 0.002, "{task}: {rms}");
    }
}

#[test]
fn from_rest_the_hand_moves_by_31_mm_and_then_by_33() {
    let recordings = read(REACH);
    let replays = Task::REACH.visit(Replay(recordings));
    // Episodes 0 to 5 go at full speed along one axis each.
    for replay in &replays[..6] {
        for error in &replay.hand_errors[..3] {
            assert!(error.norm() < 0.002, "{error}");
        }
    }
}

#[test]
fn blocks_move_as_in_fetch() {
    for (task, csv, bar) in [(Task::PUSH, PUSH, 0.015), (Task::PICK, PICK, 0.015)] {
        let replays = task.visit(Replay(read(csv)));
        let median = median(replays.iter().map(|replay| replay.block_error).collect());
        assert!(median < bar, "{task}: {median} m");
    }
}

/// The numbers of an observation mean what they mean there: units, frames, signs.
#[test]
fn observations_speak_the_language_of_fetch() {
    for (task, csv) in [(Task::PUSH, PUSH), (Task::PICK, PICK)] {
        let mut recordings = read(csv);
        // Until a little after the block is touched: later its paths differ.
        for recording in &mut recordings {
            recording.truncate(14);
        }
        let replays = task.visit(Replay(recordings));
        let errors = || replays.iter().flat_map(|replay| &replay.observation_errors);
        for i in replays[0].observation_errors[0].keys() {
            let bar = match i {
                0..11 => 0.006,
                11..14 => 0.05,
                14..17 => 0.004,
                _ => 0.0025,
            };
            let rms = root_mean_square(errors().map(|e| e[i]));

            assert!(rms < bar, "{task}, number {i}: off by {rms}");
        }
    }
}

/// One row: what was done and the numbers that were seen after it.
struct Row {
    action: Option<[f32; 4]>,
    /// By index in the observation.
    observation: BTreeMap<usize, f32>,
    target: Position,
}

impl Row {
    fn position(&self, from: usize) -> Option<Position> {
        let number = |i| self.observation.get(&i).copied();
        Some(Position::new(number(from)?, number(from + 1)?, number(from + 2)?))
    }

    fn gripper(&self) -> Position {
        self.position(0).unwrap()
    }

    /// FetchReach has no object: its target stands in for one.
    fn object(&self) -> Position {
        self.position(3).unwrap_or(self.target)
    }
}

/// Episodes, each with the reset in front.
fn read(csv: &str) -> Vec<Vec<Row>> {
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let mut recordings: Vec<Vec<Row>> = Vec::new();
    for line in lines {
        let named = |name: &str| {
            let column = header.iter().position(|h| *h == name).unwrap();
            line[column].parse::<f32>()
        };
        let observation = header
            .iter()
            .zip(&line)
            .filter_map(|(name, value)| {
                let index = name.strip_prefix("obs_")?.parse().unwrap();
                Some((index, value.parse().unwrap()))
            })
            .collect();
        let action = named("action_0")
            .is_ok()
            .then(|| std::array::from_fn(|i| named(&format!("action_{i}")).unwrap()));
        let target = ["desired_x", "desired_y", "desired_z"].map(|name| named(name).unwrap());
        if action.is_none() {
            recordings.push(Vec::new());
        }
        recordings.last_mut().unwrap().push(Row { action, observation, target: target.into() });
    }
    recordings
}

/// The same actions from the same start, whatever comes of them.
struct Replay(Vec<Vec<Row>>);

struct Replayed {
    /// How far each displacement of the hand is off, in meters.
    hand_errors: Vec<Vector3<f32>>,
    /// How far the block is from where it ended, in meters.
    block_error: f32,
    /// How far each recorded number is off, by index, at each step.
    observation_errors: Vec<BTreeMap<usize, f32>>,
}

impl EnvVisitor for Replay {
    type Output = Vec<Replayed>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Vec<Replayed> {
        let mut env = build();
        self.0.iter().map(|recording| replay(&mut env, recording)).collect()
    }
}

fn replay<const N: usize>(env: &mut impl Simulated<N>, recording: &[Row]) -> Replayed {
    let mut observation = vec![0.0; env.spec().obs_dim];
    let first = &recording[0];
    let layout = Layout::new([first.object(); N], [first.target; N]);
    let mut before = env.arrange(layout, &mut observation).unwrap().achieved;
    let mut hand_errors = Vec::new();
    let mut observation_errors = Vec::new();
    for rows in recording.windows(2) {
        let after = env.step(&rows[1].action.unwrap(), &mut observation).unwrap();
        let here = after.0.gripper - before.0.gripper;
        hand_errors.push(here - (rows[1].gripper() - rows[0].gripper()));
        let seen = &rows[1].observation;
        observation_errors.push(seen.iter().map(|(i, x)| (*i, observation[*i] - x)).collect());
        before = after;
    }
    let last = &recording[recording.len() - 1];
    let block_error = (before.0.objects[0] - last.object()).norm();
    Replayed { hand_errors, block_error, observation_errors }
}

fn root_mean_square(numbers: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / count).sqrt()
}

fn median(mut numbers: Vec<f32>) -> f32 {
    numbers.sort_by(f32::total_cmp);
    let half = numbers.len() / 2;
    f32::midpoint(numbers[half - 1], numbers[half])
}
