//! What the program does while a fault hits it, and what it leaves behind.

use crate::program::{Program, Room};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::fs;
use std::path::Path;

/// Settings of a run that takes a tenth of a second.
const SETTINGS: &str = "until = 0.0\nenv_steps = 300\n\
    [agent]\nhidden = [16, 16]\n\
    [replay]\nupdates_per_episode = 2\n\
    [evaluation]\nevery_episodes = 2\nepisodes = 5\nsubtask_episodes = 2\n";

const TRAIN: &str = "train reach --seed 3 --config ../tiny.toml --workers 1 -q --out run";
const RECORD: &str =
    "train reach --seed 3 --config ../tiny.toml --workers 1 -q --out run --record-every 2";
const RESUME: &str = "train --resume run --workers 1 -q";
const RESUME_RECORDED: &str = "train --resume run --workers 1 -q --record-every 2";
const PLAN: &str = "sweep reach --seeds 1-2 --config ../tiny.toml --out grid --plan plan.jsonl";
const SWEEP: &str = "sweep reach --seeds 1-2 --jobs 1 --config ../tiny.toml --out grid";

const CELL: &str = "sweep --plan plan.jsonl --cell 1";

/// The state of a run, all of it but for its episodes.
const CHECKPOINTS: [&str; 2] = ["checkpoint/current.ckpt", "checkpoint/previous.ckpt"];

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verb {
    /// A new run.
    Train,
    /// A new run that is recorded.
    Record,
    /// A run that was killed before its third checkpoint had its name.
    Resume,
    /// The same of a run that was recorded.
    ResumeRecorded,
    /// A sweep of two runs, of which one was begun: the process that starts them is hit.
    Sweep,
    /// A sweep of two runs: the process of the second is hit.
    SweptRun,
    /// A plan of two runs is written.
    Plan,
    /// The second run of a plan.
    Cell,
    /// A recording of a policy.
    Play,
    /// Another recording in place of one that is there.
    PlayAgain,
    /// A dataset of each format.
    Minari,
    Lerobot,
}

impl Verb {
    pub(crate) const ALL: [Self; 12] = [
        Self::Train,
        Self::Record,
        Self::Resume,
        Self::ResumeRecorded,
        Self::Sweep,
        Self::SweptRun,
        Self::Plan,
        Self::Cell,
        Self::Play,
        Self::PlayAgain,
        Self::Minari,
        Self::Lerobot,
    ];

    /// What is run in the folder `work` of a room.
    pub(crate) const fn arguments(self) -> &'static str {
        match self {
            Self::Train => TRAIN,
            Self::Record => RECORD,
            Self::Resume => RESUME,
            Self::ResumeRecorded => RESUME_RECORDED,
            Self::Sweep | Self::SweptRun => SWEEP,
            Self::Plan => PLAN,
            Self::Cell => CELL,
            Self::Play | Self::PlayAgain => "play run --episodes 2 --seed 1 --mcap play.mcap",
            Self::Minari => "export run --episodes 2 --seed 1 --format minari --out data",
            Self::Lerobot => "export run --episodes 2 --seed 1 --format lerobot --out data",
        }
    }

    /// Subcommand of the process that is hit.
    pub(crate) const fn hit(self) -> &'static str {
        match self {
            Self::Train | Self::Record | Self::Resume | Self::ResumeRecorded | Self::SweptRun => {
                "train"
            }
            Self::Sweep | Self::Plan | Self::Cell => "sweep",
            Self::Play | Self::PlayAgain => "play",
            Self::Minari | Self::Lerobot => "export",
        }
    }

    /// The folder in `work` whose calls count.
    pub(crate) const fn watched(self) -> &'static str {
        match self {
            Self::Train | Self::Record | Self::Resume | Self::ResumeRecorded => "run",
            Self::Sweep => "grid",
            Self::SweptRun => "grid/seed=2",
            Self::Plan
            | Self::Cell
            | Self::Play
            | Self::PlayAgain
            | Self::Minari
            | Self::Lerobot => "",
        }
    }

    /// Makes what the command finds.
    pub(crate) fn prepare(self, program: &Program, room: &Room) {
        fs::write(room.path("tiny.toml"), SETTINGS).unwrap();
        let ok = |arguments: &str| {
            let ended = program.run(room, arguments);
            assert_eq!(ended.status, Ok(0), "`rher {arguments}`:\n{}", ended.stderr);
        };
        match self {
            Self::Train | Self::Record | Self::SweptRun | Self::Plan => {}
            Self::Cell => ok(PLAN),
            Self::ResumeRecorded => kill_at_third_checkpoint(program, room, RECORD, "run"),
            Self::Resume => kill_at_third_checkpoint(program, room, TRAIN, "run"),
            Self::Sweep => kill_at_third_checkpoint(program, room, SWEEP, "grid/seed=1"),
            Self::Play | Self::Minari | Self::Lerobot => ok(TRAIN),
            Self::PlayAgain => {
                ok(TRAIN);
                ok("play run --episodes 1 --seed 2 --mcap play.mcap");
            }
        }
    }

    /// What leads on after a fault.
    pub(crate) fn next(self, room: &Room) -> &'static str {
        let is_begun = CHECKPOINTS.iter().any(|file| room.work().join("run").join(file).exists());
        match self {
            Self::Train | Self::Resume if is_begun => RESUME,
            Self::Record | Self::ResumeRecorded if is_begun => RESUME_RECORDED,
            verb => verb.arguments(),
        }
    }

    /// Whether checkpoints are written in the folder that is watched.
    pub(crate) const fn saves(self) -> bool {
        !matches!(self, Self::Sweep) && self.target().is_none()
    }

    /// Whether the run had begun before.
    pub(crate) const fn resumes(self) -> bool {
        matches!(self, Self::Resume | Self::ResumeRecorded)
    }

    /// Whether training is recorded.
    pub(crate) const fn records(self) -> bool {
        matches!(self, Self::Record | Self::ResumeRecorded)
    }

    /// Whether the target is a folder that gets its name when it is complete.
    pub(crate) const fn is_one_folder(self) -> bool {
        matches!(self, Self::Minari | Self::Lerobot)
    }

    /// What the command makes, complete or absent at any time.
    pub(crate) const fn target(self) -> Option<&'static str> {
        match self {
            Self::Plan => Some("plan"),
            Self::Play | Self::PlayAgain => Some("play"),
            Self::Minari | Self::Lerobot => Some("data"),
            _ => None,
        }
    }
}

impl fmt::Display for Verb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Train => "`train`",
            Self::Record => "`train --record-every`",
            Self::Resume => "`train --resume`",
            Self::ResumeRecorded => "`train --resume --record-every`",
            Self::Sweep => "`sweep`",
            Self::SweptRun => "a run of `sweep`",
            Self::Plan => "`sweep --plan`",
            Self::Cell => "`sweep --plan --cell`",
            Self::Play => "`play --mcap`",
            Self::PlayAgain => "`play --mcap` over a recording",
            Self::Minari => "`export --format minari`",
            Self::Lerobot => "`export --format lerobot`",
        })
    }
}

/// All commands, in Markdown.
pub(crate) fn page() -> String {
    let mut page = String::from("| command | what is hit |\n|---|---|\n");
    for verb in Verb::ALL {
        let what = match verb {
            Verb::Train => "a new run",
            Verb::Record => "a new run that is recorded",
            Verb::Resume => {
                "a run that was killed before its third checkpoint had its name: a line of metrics \
                 and a new state are too much, and `current.ckpt` is missing"
            }
            Verb::ResumeRecorded => "the same, with an unfinished recording",
            Verb::Sweep => {
                "the process that starts the runs of a sweep of two, one of which was begun; its \
                 runs are not hit"
            }
            Verb::SweptRun => "the process of the second run of a sweep; no other is hit",
            Verb::Plan => "a new plan of two runs",
            Verb::Cell => "the second run of a plan; the plan is read",
            Verb::Play => "a recording of a policy",
            Verb::PlayAgain => "a recording in place of another one that is complete",
            Verb::Minari | Verb::Lerobot => "a dataset of a policy's episodes",
        };
        let _ = writeln!(page, "| {verb} | {what} |");
    }
    page
}

/// The metrics are a line longer than the checkpoint knows, and `current.ckpt` is missing.
fn kill_at_third_checkpoint(program: &Program, room: &Room, arguments: &str, run: &str) {
    use crate::preload::{Call, Fault, Injection};
    let injection =
        Injection { command: "train", call: Call::Rename, at: 0, fault: Fault::KillBefore };
    let calls = {
        let trial = Room::new();
        fs::write(trial.path("tiny.toml"), SETTINGS).unwrap();
        program.run_watched(&trial, arguments, run, None).log
    };
    let mut saves = calls.iter().filter(|noted| noted.is_save());
    let at = saves.nth(2).unwrap().at;
    let injection = Injection { at, ..injection };
    program.run_watched(room, arguments, run, Some(&injection));
    assert!(!room.work().join(run).join(CHECKPOINTS[0]).exists());
    assert!(room.work().join(run).join(CHECKPOINTS[1]).exists());
}

/// What a call concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Place {
    Folder,
    Lock,
    Metrics,
    /// The settings of a run, and the machine that made it.
    Config,
    Policy,
    Checkpoint,
    Episodes,
    /// What `files::replace` writes before it gives it its name.
    New,
    Recording,
    /// What is written of it after the last checkpoint.
    EndOfRecording,
    Dataset,
    Plan,
    /// Of an attempt to train a cell.
    Worker,
    /// What gets the name of a plan or of an attempt when it is whole.
    Unnamed,
}

impl Place {
    /// From a path below the folder that is watched.
    pub(crate) fn of(path: &str) -> Self {
        let name = path.rsplit('/').next().unwrap_or_default();
        match name.rsplit_once('.').unwrap_or((name, "")) {
            _ if path.starts_with("/data") => Self::Dataset,
            ("", "lock") => Self::Lock,
            ("metrics", "jsonl") => Self::Metrics,
            ("plan", "jsonl") => Self::Plan,
            (stem, "jsonl") if stem.starts_with("worker-") => Self::Worker,
            _ if name.starts_with(".worker-") || name.starts_with(".plan.jsonl-") => Self::Unnamed,
            (_, "toml") => Self::Config,
            (_, "safetensors") => Self::Policy,
            (_, "ckpt") => Self::Checkpoint,
            (_, "episodes") => Self::Episodes,
            (_, "new") => Self::New,
            (_, "mcap" | "json") => Self::Recording,
            (_, "") => Self::Folder,
            _ if name.starts_with("seed=") => Self::Folder,
            _ => panic!("`{path}` is no file that is known"),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Folder => "folder",
            Self::Lock => "`.lock`",
            Self::Metrics => "`metrics.jsonl`",
            Self::Config => "`config.toml`, `machine.toml`",
            Self::Policy => "`policy.safetensors`",
            Self::Checkpoint => "`*.ckpt`",
            Self::Episodes => "`*.episodes`",
            Self::New => "`.rher-*.new`",
            Self::Recording => "recording",
            Self::EndOfRecording => "recording, after the last checkpoint",
            Self::Dataset => "dataset",
            Self::Plan => "plan",
            Self::Worker => "`worker-*.jsonl`",
            Self::Unnamed => "`.worker-*`, `.plan.jsonl-*`",
        })
    }
}

/// All files by their names, with what must be the same in them.
pub(crate) type Results = BTreeMap<String, Vec<u8>>;

/// The results that are in `folder`, without recordings of training: those are looked at by
/// themselves, since every resumed run begins another.
pub(crate) fn results(folder: &Path) -> Results {
    let mut results = Results::new();
    gather(folder, "", &mut results);
    results
}

fn gather(folder: &Path, below: &str, results: &mut Results) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries {
        let path = entry.unwrap().path();
        let file = path.file_name().unwrap().to_string_lossy().into_owned();
        let name = format!("{below}/{file}");
        if path.is_dir() {
            gather(&path, &name, results);
        } else if !is_recording_of_training(&file) {
            // An attempt after a fault has another number; that of the first is removed.
            let is_attempt = file.starts_with("worker-");
            let name = if is_attempt { format!("{below}/worker.jsonl") } else { name };
            results.entry(name).or_default().extend(content(&path, &file));
        }
    }
}

/// What must be the same: not the clock, which is in metrics and in checkpoints.
fn content(path: &Path, name: &str) -> Vec<u8> {
    let bytes = fs::read(path).unwrap();
    match name {
        ".lock" | "current.ckpt" | "previous.ckpt" => Vec::new(),
        "metrics.jsonl" => {
            let lines = String::from_utf8_lossy(&bytes).into_owned();
            lines.lines().map(without_clock).collect::<String>().into_bytes()
        }
        // How the attempt ended: its other lines say who made it, and how fast.
        _ if name.starts_with("worker-") => {
            String::from_utf8_lossy(&bytes).lines().skip(2).collect::<String>().into_bytes()
        }
        _ => bytes,
    }
}

/// A line without what depends on the clock.
fn without_clock(line: &str) -> String {
    match serde_json::from_str(line) {
        Ok(Value::Object(mut metrics)) => {
            metrics.remove("wall_s");
            metrics.remove("time");
            // That of a line with its clock.
            metrics.remove("crc32");
            format!("{}\n", Value::Object(metrics))
        }
        _ => format!("damaged: {line}\n"),
    }
}

/// Finished ones alone.
pub(crate) fn is_recording_of_training(name: &str) -> bool {
    let number = name.strip_prefix("episodes-").and_then(|rest| rest.split_once('.'));
    number.is_some_and(|(_, end)| matches!(end, "mcap" | "layout.json"))
}
