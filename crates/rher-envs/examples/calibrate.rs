//! Replays recorded episodes of a real Fetch environment and prints how far this one is from them.
//!
//! ```console
//! $ cargo run --release -p rher-envs --example calibrate -- push tests/data/fetch_push.csv
//! ```
//!
//! The file has a header and one row for each step, with the columns `kind`, `step`, `action_*`,
//! `obs_*` and `desired_*`; row `step` 0 is the reset.

use nalgebra::Vector3;
use rher_core::env::EnvError;
use rher_core::goal::Position;
use rher_envs::{EnvVisitor, Layout, Simulated, Task};
use std::collections::BTreeMap;
use std::error::Error;
use std::process::ExitCode;

/// Rows of one episode, with the reset in front.
type Recording = Vec<Row>;

/// One step: the action and what it led to.
struct Row {
    action: Vec<f32>,
    gripper: Position,
    object: Position,
    target: Position,
}

#[expect(clippy::print_stderr, reason = "a program for the terminal")]
fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [task, file] = arguments.as_slice() else {
        return Err("usage: calibrate TASK FILE.csv".into());
    };
    let task: Task = task.parse()?;
    let recordings = read(&std::fs::read_to_string(file)?)?;
    for (kind, recordings) in recordings {
        task.visit(Compare { kind, recordings })?;
    }
    Ok(())
}

/// Episodes by kind.
fn read(csv: &str) -> Result<BTreeMap<String, Vec<Recording>>, Box<dyn Error>> {
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().ok_or("the file is empty")?;
    let column = |name: &str| {
        header.iter().position(|h| *h == name).ok_or_else(|| format!("no column `{name}`"))
    };
    let (kind, step, action) = (column("kind")?, column("step")?, column("action_0")?);
    let (gripper, target) = (column("obs_0")?, column("desired_x")?);
    // FetchReach has 10 numbers and no object: the target stands in for it.
    let object = if column("obs_20").is_ok() { column("obs_3")? } else { target };

    let mut kinds: BTreeMap<String, Vec<Recording>> = BTreeMap::new();
    for line in lines {
        let number = |i: usize| line[i].parse::<f32>();
        let position = |i: usize| -> Result<Position, Box<dyn Error>> {
            Ok(Position::new(number(i)?, number(i + 1)?, number(i + 2)?))
        };
        let is_reset = line[step] == "0";
        let row = Row {
            action: if is_reset {
                Vec::new()
            } else {
                (action..action + 4).map(number).collect::<Result<_, _>>()?
            },
            gripper: position(gripper)?,
            object: position(object)?,
            target: position(target)?,
        };
        let recordings = kinds.entry(line[kind].to_owned()).or_default();
        if is_reset {
            recordings.push(Vec::new());
        }
        recordings.last_mut().ok_or("the first row is not a reset")?.push(row);
    }
    Ok(kinds)
}

struct Compare {
    kind: String,
    recordings: Vec<Recording>,
}

impl EnvVisitor for Compare {
    type Output = Result<(), EnvError>;

    #[expect(clippy::print_stdout, reason = "a program for the terminal")]
    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { kind, recordings } = self;
        let mut env = build();
        println!("{} {kind}", env.spec().name);
        println!(
            "episode  hand off by x, y, z (rms, mm a step)  object moved here, there, apart (mm)"
        );
        let mut hand = Squares::default();
        let mut apart = Vec::new();
        for (episode, recording) in recordings.iter().enumerate() {
            let replay = replay(&mut env, recording)?;
            let [x, y, z] = replay.hand.root_mean();
            let (here, there) = replay.object_moved;
            println!(
                "{episode:>7} {x:>19.2} {y:>5.2} {z:>5.2} {:>27.0} {:>6.0} {:>6.0}",
                here.norm(),
                there.norm(),
                (here - there).norm(),
            );
            hand.join(&replay.hand);
            apart.push((here - there).norm());
        }
        apart.sort_by(f32::total_cmp);
        let [x, y, z] = hand.root_mean();
        println!("all     {x:>19.2} {y:>5.2} {z:>5.2} {:>34} {:>6.0}\n", "median", median(&apart));
        Ok(())
    }
}

/// What a replayed episode comes to, in millimeters.
struct Replay {
    /// How far each displacement of the hand is off.
    hand: Squares,
    /// How far the object is from its start in the end: here and there.
    object_moved: (Vector3<f32>, Vector3<f32>),
}

/// Starts where the recording did and repeats its actions, whatever comes of them.
fn replay<const N: usize>(
    env: &mut impl Simulated<N>,
    recording: &[Row],
) -> Result<Replay, EnvError> {
    let mut observation = vec![0.0; env.spec().obs_dim];
    let (first, last) = (&recording[0], &recording[recording.len() - 1]);
    let layout = Layout::new([first.object; N], [first.target; N]);
    let start = env.arrange(layout, &mut observation)?.achieved;
    let mut before = start;
    let mut hand = Squares::default();
    for rows in recording.windows(2) {
        let after = env.step(&rows[1].action, &mut observation)?;
        let here = after.0.gripper - before.0.gripper;
        hand.add(1000.0 * (here - (rows[1].gripper - rows[0].gripper)));
        before = after;
    }
    let here = 1000.0 * (before.0.objects[0] - start.0.objects[0]);
    Ok(Replay { hand, object_moved: (here, 1000.0 * (last.object - first.object)) })
}

/// A sum of squares along each axis.
#[derive(Default)]
struct Squares {
    sum: Vector3<f32>,
    count: f32,
}

impl Squares {
    fn add(&mut self, error: Vector3<f32>) {
        self.sum += error.component_mul(&error);
        self.count += 1.0;
    }

    fn join(&mut self, other: &Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    fn root_mean(&self) -> [f32; 3] {
        (self.sum / self.count).map(f32::sqrt).into()
    }
}

/// Of sorted numbers.
fn median(sorted: &[f32]) -> f32 {
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[half] } else { f32::midpoint(sorted[half - 1], sorted[half]) }
}
