//! The file of an attempt to train a cell: who makes it, how far it is, how it ended.
//!
//! `worker-0.jsonl` is the first attempt, `worker-1.jsonl` the second; the one with the highest
//! number counts. Its lines are a [`Worker`], a [`Beat`], and at the end an [`End`].

use super::plan::PlanId;
use rher_core::files::{self, FileError, is_absent};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

const START: &str = "worker-";
const ENDING: &str = ".jsonl";

/// Largest file in bytes; messages of errors are short.
const LARGEST: u64 = 1 << 20;

/// Bytes of the second line, which is written over again and again.
pub(super) const BEAT_BYTES: usize = 96;

/// Who makes an attempt.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Worker {
    /// The plan whose cell it is.
    pub plan: PlanId,
    /// Number of the cell.
    pub cell: usize,
    /// Name of the machine.
    pub host: String,
    /// What no other machine has, and this one has only until it starts anew.
    pub boot: String,
    /// The process on that machine.
    pub process: u32,
}

/// How far an attempt is. Who sees it change knows that the worker lives; no two clocks are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beat {
    /// Goes up for as long as the worker lives.
    pub beat: u64,
    /// Environment steps of the run.
    pub env_steps: u64,
    /// Environment steps per second in this attempt.
    pub steps_per_s: f64,
}

/// How an attempt ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct End {
    /// Exit status of the program.
    pub status: u8,
    /// What went wrong, if something did.
    pub error: Option<String>,
}

/// Whether the worker of an attempt is alive, as far as one look says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Life {
    /// It holds its lock.
    Locked,
    /// It was a process of this machine, and its lock is gone.
    Dead,
    /// It is on another machine, or the file system has no locks: its beat has to be watched.
    Unknown,
}

/// An attempt, as it was found.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Counted from 0.
    pub number: u64,
    /// Who makes it.
    pub worker: Worker,
    /// How far it is.
    pub beat: Beat,
    /// How it ended, if it has.
    pub end: Option<End>,
    /// Whether its worker lives.
    pub life: Life,
}

/// The file of an attempt cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum AttemptError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// It does not say who makes the attempt.
    #[error("`{}` is damaged: its first line does not say who works there", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
    },
}

impl Worker {
    /// This process.
    pub(super) fn here(plan: PlanId, cell: usize) -> Self {
        let of_system = |name: &str| {
            let text = std::fs::read_to_string(Path::new("/proc/sys/kernel").join(name));
            text.map_or_else(|_| "unknown".to_owned(), |text| text.trim().to_owned())
        };
        Self {
            plan,
            cell,
            host: of_system("hostname"),
            boot: of_system("random/boot_id"),
            process: std::process::id(),
        }
    }

    /// The first line.
    pub(super) fn line(&self) -> String {
        serde_json::to_string(self).expect("numbers and text are JSON") + "\n"
    }

    fn is_of_this_machine(&self) -> bool {
        let here = Self::here(self.plan.clone(), self.cell);
        here.boot != "unknown" && here.boot == self.boot
    }
}

impl End {
    /// The third line.
    pub(super) fn line(&self) -> String {
        serde_json::to_string(self).expect("a number and text are JSON") + "\n"
    }
}

impl fmt::Display for Worker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {} on {}", self.process, self.host)
    }
}

/// The file of attempt `number` in `folder`.
pub(super) fn path(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{START}{number}{ENDING}"))
}

/// The number of the attempt whose file has this name.
pub(super) fn number(name: &str) -> Option<u64> {
    name.strip_prefix(START)?.strip_suffix(ENDING)?.parse().ok()
}

/// The second line.
pub(super) fn beat_line(beat: &Beat) -> String {
    let text = serde_json::to_string(beat).expect("numbers are JSON");
    format!("{text:width$}\n", width = BEAT_BYTES - 1)
}

/// The last attempt to train the cell in `folder`; `None` if nobody has begun.
///
/// # Errors
///
/// If its file cannot be read.
pub fn look(folder: &Path) -> Result<Option<Seen>, AttemptError> {
    // A later attempt removes the file of an earlier one, perhaps between two looks.
    for _ in 0..10 {
        let Some(number) = last(folder)? else { return Ok(None) };
        match read(folder, number) {
            Err(AttemptError::File(error)) if is_absent(&error.source) => {}
            seen => return seen.map(Some),
        }
    }
    Ok(None)
}

/// The highest number of an attempt in `folder`.
fn last(folder: &Path) -> Result<Option<u64>, FileError> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if is_absent(&error) => return Ok(None),
        entries => entries.map_err(FileError::read(folder))?,
    };
    let mut last = None;
    for entry in entries {
        let entry = entry.map_err(FileError::read(folder))?;
        last = last.max(entry.file_name().to_str().and_then(number));
    }
    Ok(last)
}

fn read(folder: &Path, number: u64) -> Result<Seen, AttemptError> {
    let path = path(folder, number);
    let bytes = files::read_at_most(&path, LARGEST)?;
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = text.lines();
    let worker = lines.next().and_then(|line| serde_json::from_str(line).ok());
    let worker: Worker = worker.ok_or_else(|| AttemptError::Damaged { path: path.clone() })?;
    // A line that is being written says nothing.
    let beat = lines.next().and_then(|line| serde_json::from_str(line.trim_end()).ok());
    let end = lines.next().and_then(|line| serde_json::from_str(line).ok());
    let life = life(&path, &worker)?;
    Ok(Seen { number, worker, beat: beat.unwrap_or_default(), end, life })
}

fn life(path: &Path, worker: &Worker) -> Result<Life, FileError> {
    let file = File::open(path).map_err(FileError::read(path))?;
    // A shared lock, so that those who look do not take each other for the worker.
    Ok(match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Life::Locked,
        Ok(()) if worker.is_of_this_machine() => Life::Dead,
        Ok(()) | Err(TryLockError::Error(_)) => Life::Unknown,
    })
}
