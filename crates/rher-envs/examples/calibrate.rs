//! Replays recorded episodes of a real Fetch environment and prints how far this one is from them.
//!
//! ```console
//! $ cargo run --release -p rher-envs --example calibrate -- push fetch_push.csv
//! ```
//!
//! The file has one row for each step, a header, and the columns `kind`, `episode`, `step`,
//! `action_*`, `obs_*`, `achieved_*` and `desired_*`; row `step` 0 is the reset.

use rher_core::env::EnvError;
use rher_core::goal::Position;
use rher_envs::{EnvVisitor, Layout, Simulated, Task};
use std::collections::BTreeMap;
use std::error::Error;
use std::process::ExitCode;

/// Rows of one episode, with the reset in front.
type Recording = Vec<Row>;

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
    let (gripper, object, target) = (column("obs_0")?, column("achieved_x")?, column("desired_x")?);

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
    fn visit<const N: usize, E: Simulated<N>>(self, build: fn() -> E) -> Self::Output {
        let Self { kind, recordings } = self;
        let mut env = build();
        let mut observation = vec![0.0; env.spec().observation];
        let mut squares = [0.0; 3];
        let mut steps = 0.0;
        println!("{} {kind}", env.spec().name);
        println!("episode  hand rms x  y  z (mm/step)   object moved: here, there, apart (mm)");
        let mut apart = Vec::new();
        for (episode, recording) in recordings.iter().enumerate() {
            let first = &recording[0];
            let layout = Layout { objects: [first.object; N], targets: [first.target; N] };
            let mut before = env.arrange(layout, &mut observation)?.achieved;
            let start = before;
            let mut sums = [0.0; 3];
            for pair in recording.windows(2) {
                let after = env.step(&pair[1].action, &mut observation)?;
                let moved = after.0.gripper - before.0.gripper;
                let error = moved - (pair[1].gripper - pair[0].gripper);
                for axis in 0..3 {
                    sums[axis] += error[axis] * error[axis];
                }
                if std::env::var("VERBOSE").is_ok_and(|v| v == episode.to_string()) {
                    println!(
                        "{:?} here {:.4?} there {:.4?} | {:.4?} {:.4?}",
                        pair[1].action,
                        after.0.gripper.coords.as_slice(),
                        pair[1].gripper.coords.as_slice(),
                        after.0.objects[0].coords.as_slice(),
                        pair[1].object.coords.as_slice()
                    );
                }
                before = after;
            }
            let count = (recording.len() - 1) as f32;
            let rms = sums.map(|s| 1000.0 * (s / count).sqrt());
            let here = 1000.0 * (before.0.objects[0] - start.0.objects[0]);
            let last = &recording[recording.len() - 1];
            let there = 1000.0 * (last.object - first.object);
            println!(
                "{episode:>7}  {:>10.2} {:>5.2} {:>5.2} {:>30.0} {:>6.0} {:>6.0}",
                rms[0],
                rms[1],
                rms[2],
                here.norm(),
                there.norm(),
                (here - there).norm()
            );
            apart.push((here - there).norm());
            for axis in 0..3 {
                squares[axis] += sums[axis];
            }
            steps += count;
        }
        apart.sort_by(f32::total_cmp);
        let rms = squares.map(|s| 1000.0 * (s / steps).sqrt());
        println!(
            "all      {:>10.2} {:>5.2} {:>5.2}   median apart {:.0}\n",
            rms[0],
            rms[1],
            rms[2],
            apart[apart.len() / 2]
        );
        Ok(())
    }
}
