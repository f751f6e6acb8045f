//! Who trains a cell: one process at a time, whatever the file system can do.
//!
//! An attempt is a file that is made under a name that no other file has, so of two workers one
//! makes it. Its worker holds a lock on it, and counts in it. The lock says at once whether a worker
//! of the same machine lives, and of another one where the file system shares locks. Where it does
//! not, the count says it: if it stands still for [`PATIENCE`] by the clock of the one who watches,
//! the worker is dead, and the next attempt may begin. One that was only asleep finds the next
//! attempt before it writes anything, and ends.

use super::attempt::{self, AttemptError, Beat, End, Life, Seen, Worker, beat_line, look};
use super::plan::PlanId;
use super::unnamed::{Unnamed, is_unnamed, remove_where};
use rher_core::files::FileError;
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How often a worker counts.
const EVERY: Duration = Duration::from_secs(1);

/// How long the count of a worker stands still until it is dead.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// How often the count is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// The right to train a cell, for as long as this value lives.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    guard: Guard,
    pulse: Pulse,
    counting: Option<JoinHandle<()>>,
    /// Locked until the process ends.
    _lock: File,
}

/// Says whether a claim still stands.
#[derive(Clone, Debug)]
pub struct Guard {
    /// The file of this attempt, which later ones remove.
    own: PathBuf,
    /// The file that the next attempt begins with.
    next: PathBuf,
    cell: usize,
}

/// The claim was lost: this process was silent for so long that another one began.
#[derive(Debug, thiserror::Error)]
#[error("cell {cell} was taken over by another worker, because this one was silent for too long")]
pub struct Lost {
    /// Number of the cell.
    pub cell: usize,
}

/// A cell cannot be claimed.
#[derive(Debug, thiserror::Error)]
pub enum ClaimError {
    /// Another worker has it.
    #[error("cell {} is being trained by {worker}", worker.cell)]
    Busy {
        /// The other worker.
        worker: Box<Worker>,
    },
    /// The folder is that of another cell.
    #[error(
        "`{}` belongs to cell {} of plan {}, and not to cell {cell} of plan {plan}",
        folder.display(),
        owner.cell,
        owner.plan
    )]
    Owned {
        /// The folder.
        folder: PathBuf,
        /// The worker that was there last.
        owner: Box<Worker>,
        /// The plan of the cell that was asked for.
        plan: PlanId,
        /// Its number.
        cell: usize,
    },
    /// The file of an attempt cannot be used.
    #[error(transparent)]
    Attempt(#[from] AttemptError),
}

impl From<FileError> for ClaimError {
    fn from(error: FileError) -> Self {
        Self::Attempt(error.into())
    }
}

/// The progress of a worker, which others see.
#[derive(Clone, Debug, Default)]
pub struct Pulse(Arc<(Mutex<State>, Condvar)>);

#[derive(Debug, Default)]
struct State {
    /// Environment steps when the run began or was resumed, and when that was.
    first: Option<(u64, Instant)>,
    env_steps: u64,
    beat: u64,
    is_over: bool,
}

impl Pulse {
    /// Takes note of how far the run is.
    pub fn report(&self, env_steps: u64) {
        let mut state = self.lock();
        state.first.get_or_insert_with(|| (env_steps, Instant::now()));
        state.env_steps = env_steps;
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn beat(state: &mut State) -> Beat {
        state.beat += 1;
        let rate = state.first.map_or(0.0, |(steps, at)| {
            (state.env_steps - steps) as f64 / at.elapsed().as_secs_f64().max(1e-3)
        });
        let steps_per_s = (rate * 10.0).round() / 10.0;
        Beat { beat: state.beat, env_steps: state.env_steps, steps_per_s }
    }

    /// Counts in the file of the attempt until the claim is over, and once more then.
    fn count(&self, path: &Path, at: u64) {
        let mut state = self.lock();
        loop {
            let (beat, is_last) = (Self::beat(&mut state), state.is_over);
            drop(state);
            // Closed each time, because only then other machines see what was written. A count that
            // cannot be written is like one that comes late.
            let file = OpenOptions::new().write(true).open(path);
            let _ = file.and_then(|file| write_at(&file, beat_line(&beat).as_bytes(), at));
            if is_last {
                return;
            }
            state = self.lock();
            if !state.is_over {
                let waited = self.0.1.wait_timeout(state, EVERY);
                state = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
        }
    }
}

impl Guard {
    /// Whether the claim still stands; to be asked before something is written.
    ///
    /// # Errors
    ///
    /// If another worker has taken over.
    pub fn check(&self) -> Result<(), Lost> {
        if self.own.exists() && !self.next.exists() {
            Ok(())
        } else {
            Err(Lost { cell: self.cell })
        }
    }
}

impl Claim {
    /// Takes cell number `cell` of a plan, whose folder this is, for this process; `None` if it has
    /// been trained to its end.
    ///
    /// If the last worker was on another machine and may be dead, this waits: until its count goes
    /// up, or for `patience`. `wait` is called once before that.
    ///
    /// # Errors
    ///
    /// If another worker has it, or if the folder is that of another cell or plan.
    pub fn take(
        folder: &Path,
        plan: &PlanId,
        cell: usize,
        patience: Duration,
        wait: impl FnOnce(&Worker),
    ) -> Result<Option<Self>, ClaimError> {
        std::fs::create_dir_all(folder).map_err(FileError::write(folder))?;
        let mut wait = Some(wait);
        loop {
            let seen = look(folder)?;
            if let Some(seen) = &seen {
                let owner = &seen.worker;
                if (&owner.plan, owner.cell) != (plan, cell) {
                    let (folder, owner) = (folder.to_owned(), Box::new(owner.clone()));
                    return Err(ClaimError::Owned { folder, owner, plan: plan.clone(), cell });
                }
                if seen.end.as_ref().is_some_and(|end| end.status == 0) {
                    return Ok(None);
                }
                if let Some(wait) =
                    wait.take_if(|_| seen.end.is_none() && seen.life == Life::Unknown)
                {
                    wait(owner);
                }
                if !is_over(folder, seen, patience)? {
                    return Err(ClaimError::Busy { worker: Box::new(owner.clone()) });
                }
            }
            let number = seen.map_or(0, |seen| seen.number + 1);
            if let Some(claim) = Self::make(folder, plan, cell, number)? {
                return Ok(Some(claim));
            }
        }
    }

    /// Begins an attempt; `None` if another worker was faster.
    fn make(
        folder: &Path,
        plan: &PlanId,
        cell: usize,
        number: u64,
    ) -> Result<Option<Self>, ClaimError> {
        let worker = Worker::here(plan.clone(), cell);
        let first = worker.line();
        let beat = beat_line(&Beat::default());
        let path = attempt::path(folder, number);
        // It is whole and locked before it has its name.
        let mut new = Unnamed::create(folder, UNFINISHED)?;
        let written = new.file.write_all((first.clone() + &beat).as_bytes());
        written.map_err(FileError::write(&new.path))?;
        // Where there are no locks, the count alone says that this worker lives.
        let _ = new.file.try_lock();
        let Some(lock) = new.name(&path)? else { return Ok(None) };
        if look(folder)?.is_some_and(|seen| seen.number > number) {
            let _ = std::fs::remove_file(&path);
            return Ok(None);
        }
        remove_earlier(folder, number)?;
        let next = attempt::path(folder, number + 1);
        let guard = Guard { own: path.clone(), next, cell };
        let pulse = Pulse::default();
        let (counted, at, of) = (path.clone(), first.len() as u64, pulse.clone());
        let counting = thread::Builder::new().name("claim".to_owned());
        let counting = counting.spawn(move || of.count(&counted, at));
        let counting = Some(counting.map_err(FileError::write(&path))?);
        Ok(Some(Self { path, guard, pulse, counting, _lock: lock }))
    }

    /// Where the progress of the run is to be reported.
    pub fn pulse(&self) -> Pulse {
        self.pulse.clone()
    }

    /// What says whether the claim still stands.
    pub fn guard(&self) -> Guard {
        self.guard.clone()
    }

    /// Ends the claim, and notes how the attempt ended.
    ///
    /// # Errors
    ///
    /// If the file system refuses; then the attempt looks like one that was killed.
    pub fn end(mut self, end: &End) -> Result<(), FileError> {
        self.stop();
        if self.guard.check().is_err() {
            return Ok(());
        }
        let line = end.line();
        let file = OpenOptions::new().append(true).open(&self.path);
        file.and_then(|mut file| file.write_all(line.as_bytes()))
            .map_err(FileError::write(&self.path))
    }

    /// Stops counting, once what has happened is counted.
    fn stop(&mut self) {
        let Some(counting) = self.counting.take() else { return };
        self.pulse.lock().is_over = true;
        self.pulse.0.1.notify_all();
        counting.join().expect("who counts does not panic");
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.stop();
    }
}

#[cfg(unix)]
fn write_at(file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, at)
}

#[cfg(not(unix))]
fn write_at(mut file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
    use std::io::Seek as _;
    file.seek(io::SeekFrom::Start(at))?;
    file.write_all(bytes)
}

/// How the names of files begin that are no attempts yet.
const UNFINISHED: &str = ".worker-";

/// Whether an attempt is over: it ended, or its worker is dead.
fn is_over(folder: &Path, seen: &Seen, patience: Duration) -> Result<bool, ClaimError> {
    match (&seen.end, seen.life) {
        (Some(_), _) | (None, Life::Dead) => return Ok(true),
        (None, Life::Locked) => return Ok(false),
        (None, Life::Unknown) => {}
    }
    let started = Instant::now();
    while started.elapsed() < patience {
        thread::sleep(LOOK_EVERY.min(patience / 4));
        let Some(now) = look(folder)? else { return Ok(true) };
        if now.end.is_some() {
            return Ok(true);
        }
        if (now.number, now.beat) != (seen.number, seen.beat) || now.life == Life::Locked {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Removes the files of earlier attempts, and what workers left that were killed before theirs
/// began.
fn remove_earlier(folder: &Path, number: u64) -> Result<(), FileError> {
    let is_earlier = |name: &str| attempt::number(name).is_some_and(|of| of < number);
    remove_where(folder, |name| is_earlier(name) || is_unnamed(name, UNFINISHED))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: Duration = Duration::from_millis(400);

    fn plan(name: &str) -> PlanId {
        serde_json::from_str(&format!("\"{name}\"")).unwrap()
    }

    fn take(folder: &Path) -> Result<Option<Claim>, ClaimError> {
        Claim::take(folder, &plan("a"), 3, SHORT, |_| ())
    }

    fn end(status: u8) -> End {
        End { status, error: None }
    }

    fn files(folder: &Path) -> Vec<String> {
        let names = std::fs::read_dir(folder).unwrap();
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    /// The attempt looks as if another machine made it, which has no lock that could be seen here.
    fn of_another_machine(folder: &Path, number: u64) -> PathBuf {
        let path = attempt::path(folder, number);
        let text = std::fs::read_to_string(&path).unwrap();
        let here = Worker::here(plan("a"), 3);
        let there = "0".repeat(here.boot.len());
        std::fs::remove_file(&path).unwrap();
        std::fs::write(&path, text.replace(&here.boot, &there)).unwrap();
        path
    }

    #[test]
    fn a_cell_belongs_to_one_worker_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let claim = take(folder.path()).unwrap().unwrap();
        assert!(matches!(take(folder.path()), Err(ClaimError::Busy { .. })));
        claim.pulse().report(50);
        claim.pulse().report(150);
        claim.end(&end(143)).unwrap();
        let seen = look(folder.path()).unwrap().unwrap();
        assert_eq!((seen.number, seen.beat.env_steps, seen.end), (0, 150, Some(end(143))));
        // One that was stopped is continued, one that is done is not.
        take(folder.path()).unwrap().unwrap().end(&end(0)).unwrap();
        assert!(take(folder.path()).unwrap().is_none());
        assert_eq!(files(folder.path()), ["worker-1.jsonl"]);
    }

    #[test]
    fn of_many_workers_one_gets_the_cell() {
        let folder = tempfile::tempdir().unwrap();
        for round in 0..20 {
            let claims: Vec<_> = thread::scope(|scope| {
                let threads: Vec<_> = (0..8).map(|_| scope.spawn(|| take(folder.path()))).collect();
                threads.into_iter().map(|thread| thread.join().unwrap()).collect()
            });
            let mut got: Vec<_> = claims.into_iter().filter_map(Result::ok).collect();
            assert_eq!(got.len(), 1, "round {round}");
            got.pop().unwrap().unwrap().end(&end(143)).unwrap();
            assert_eq!(files(folder.path()), [format!("worker-{round}.jsonl")]);
        }
    }

    #[test]
    fn a_worker_that_was_killed_is_dead_at_once() {
        let folder = tempfile::tempdir().unwrap();
        // Like a kill, it ends nothing, and the lock is gone.
        drop(take(folder.path()).unwrap());
        let started = Instant::now();
        assert!(take(folder.path()).unwrap().is_some());
        assert!(started.elapsed() < SHORT);
    }

    #[test]
    fn a_folder_of_another_plan_or_cell_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        take(folder.path()).unwrap().unwrap().end(&end(0)).unwrap();
        for (other, cell) in [("b", 3), ("a", 4)] {
            let taken = Claim::take(folder.path(), &plan(other), cell, SHORT, |_| ());
            assert!(matches!(taken, Err(ClaimError::Owned { .. })));
        }
        assert_eq!(files(folder.path()), ["worker-0.jsonl"]);
    }

    #[test]
    fn a_worker_of_another_machine_is_dead_once_it_does_not_count_any_more() {
        let folder = tempfile::tempdir().unwrap();
        drop(take(folder.path()).unwrap());
        of_another_machine(folder.path(), 0);
        let (started, mut waited) = (Instant::now(), 0);
        let taken = Claim::take(folder.path(), &plan("a"), 3, SHORT, |_| waited += 1);
        assert!(taken.unwrap().is_some() && started.elapsed() >= SHORT);
        assert_eq!(waited, 1);
    }

    #[test]
    fn a_worker_of_another_machine_lives_while_it_counts() {
        let folder = tempfile::tempdir().unwrap();
        drop(take(folder.path()).unwrap());
        let path = of_another_machine(folder.path(), 0);
        let text = std::fs::read_to_string(&path).unwrap();
        let at = text.find('\n').unwrap() + 1;
        thread::scope(|scope| {
            let count = scope.spawn(|| {
                for beat in 100..105 {
                    thread::sleep(SHORT / 4);
                    let line = beat_line(&Beat { beat, ..Beat::default() });
                    let file = OpenOptions::new().write(true).open(&path).unwrap();
                    write_at(&file, line.as_bytes(), at as u64).unwrap();
                }
            });
            assert!(matches!(take(folder.path()), Err(ClaimError::Busy { .. })));
            count.join().unwrap();
        });
    }

    #[test]
    fn a_worker_that_was_asleep_finds_that_its_cell_was_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let asleep = take(folder.path()).unwrap().unwrap();
        assert!(asleep.guard().check().is_ok());
        of_another_machine(folder.path(), 0);
        asleep.pulse().lock().is_over = true;
        thread::sleep(Duration::from_millis(50));
        let awake = take(folder.path()).unwrap().unwrap();
        assert!(asleep.guard().check().is_err());
        assert!(awake.guard().check().is_ok());
        // Also when that worker has ended, and the next one has removed all traces of it.
        awake.end(&end(143)).unwrap();
        let last = take(folder.path()).unwrap().unwrap();
        assert_eq!(files(folder.path()), ["worker-2.jsonl"]);
        assert!(asleep.guard().check().is_err() && last.guard().check().is_ok());
        asleep.end(&end(0)).unwrap();
        assert!(matches!(take(folder.path()), Err(ClaimError::Busy { .. })));
    }

    #[test]
    fn the_beat_has_its_place_whatever_it_counts() {
        let most = Beat { beat: u64::MAX, env_steps: u64::MAX, steps_per_s: 123_456_789.5 };
        for beat in [Beat::default(), most] {
            assert_eq!(beat_line(&beat).len(), attempt::BEAT_BYTES);
        }
    }
}
