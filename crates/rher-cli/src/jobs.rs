//! Many runs, a few at a time, each in a process and a folder of its own.

use crate::children::Children;
use crate::errors::{ForeignTask, SameRun};
use crate::exit_code::Status;
use crate::host::Again;
use crate::numbers::{percent, thousands};
use crate::printer::Printer;
use crate::tables::{table, text};
use crate::trained::made_with;
use anyhow::Context as _;
use rher_core::files::FileError;
use rher_core::train::checkpoint::{self, CheckpointError};
use rher_envs::Task;
use rher_runs::sweep::{AttemptError, Cell, Plan, look};
use rher_runs::{
    Evaluation, MetricsError, OtherSettings, Settings, difference, read_evaluations, settings,
};
use serde::Serialize;
use sha2::{Digest as _, Sha256};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Longest name of a folder, in bytes; file systems allow 255, and files beside it have longer names.
const LONGEST_NAME: usize = 200;

/// One run.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// What it is one of several seeds of; jobs of one cell are neighbors.
    pub(crate) cell: String,
    pub(crate) task: Task,
    /// All of them, read before the first run starts.
    pub(crate) settings: Settings,
    pub(crate) folder: PathBuf,
}

impl Job {
    /// A run in a folder below `out`, such as `relay.mirror=0.5,seed=1`; a name that is too long is
    /// cut, and ends with a hash of all of it.
    pub(crate) fn new(out: &Path, cell: String, task: Task, settings: Settings) -> Self {
        let seed = format!("seed={}", settings.config.seed);
        let parts: Vec<_> = cell.split_whitespace().chain([seed.as_str()]).collect();
        let name = parts.join(",").replace('"', "").replace('/', "_");
        let folder = out.join(cut(&name));
        Self { cell, task, settings, folder }
    }

    /// The job of a cell of a plan.
    pub(crate) fn of_plan(plan: &Plan, cell: &Cell) -> anyhow::Result<Self> {
        let name = cell.settings.config.task.clone();
        Ok(Self {
            cell: cell.group.clone(),
            task: name.parse().map_err(|_| ForeignTask { name })?,
            settings: cell.settings.clone(),
            folder: plan.folder(cell),
        })
    }

    fn name(&self) -> Cow<'_, str> {
        self.folder.file_name().unwrap_or_default().to_string_lossy()
    }

    /// The command that begins the run or resumes it, and what it reads.
    fn command(&self, again: &Again) -> anyhow::Result<(Command, String)> {
        let mut command = again.command();
        let parent = std::process::id().to_string();
        command.args(["train", "--quiet", "--workers", "1", "--parent", &parent]);
        let config = &self.settings.config;
        if holds_run(&self.folder)? {
            let (env_steps, until) = (config.env_steps.to_string(), config.until.to_string());
            command.arg("--resume").arg(&self.folder);
            command.args(["--env-steps", &env_steps, "--until", &until]);
            command.stdin(Stdio::null());
            return Ok((command, String::new()));
        }
        command.arg(self.task.name()).arg("--out").arg(&self.folder);
        command.args(["--config", "/dev/stdin"]).stdin(Stdio::piped());
        Ok((command, settings::to_toml(&self.settings)?))
    }

    /// Whether the run in its folder, if there is one, is this one.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        let folder = &self.folder;
        let config = match checkpoint::read_config(folder) {
            Err(CheckpointError::Missing { .. }) => return Ok(()),
            config => config?,
        };
        let options = made_with(&checkpoint::read_variant(folder)?, self.task)?;
        match difference(&Settings { config, options }, &self.settings)? {
            Some((key, found, asked)) => {
                let folder = folder.to_owned();
                Err(OtherSettings { folder, key, found, asked }.into())
            }
            None => Ok(()),
        }
    }
}

/// A name that file systems take.
fn cut(name: &str) -> String {
    if name.len() <= LONGEST_NAME {
        return name.to_owned();
    }
    let hash: String = Sha256::digest(name)[..8]
        .iter()
        .fold(String::new(), |text, byte| text + &format!("{byte:02x}"));
    let end = name.floor_char_boundary(LONGEST_NAME - hash.len() - 1);
    format!("{}-{hash}", &name[..end])
}

/// Takes no lock, which could keep another process from training that run.
pub(crate) fn holds_run(folder: &Path) -> Result<bool, CheckpointError> {
    match checkpoint::read_config(folder) {
        Err(CheckpointError::Missing { .. }) => Ok(false),
        config => config.map(|_| true),
    }
}

/// No two jobs are the same run.
pub(crate) fn check_distinct(jobs: &[Job]) -> anyhow::Result<()> {
    let mut known = HashMap::new();
    for job in jobs {
        let text = settings::to_toml(&job.settings)?;
        if let Some(first) = known.insert(text, &job.cell) {
            let (first, second) = (first.clone(), job.cell.clone());
            return Err(SameRun { first, second }.into());
        }
    }
    Ok(())
}

/// Many runs, or all cells of a plan.
pub(crate) struct Work<'a> {
    pub(crate) jobs: &'a [Job],
    /// The plan whose cells the jobs are.
    pub(crate) plan: Option<&'a Plan>,
    pub(crate) at_a_time: usize,
}

/// What became of a job.
enum Outcome {
    Done,
    Failed,
    /// Another worker has it.
    Elsewhere,
    /// It was asked to end.
    Interrupted(Status),
    /// This program was asked to end before it began.
    NotBegun,
}

impl Work<'_> {
    /// Does all jobs, and prints their results.
    ///
    /// Done again, it resumes runs that were interrupted and does not touch finished ones.
    pub(crate) fn run(
        &self,
        json: bool,
        again: &Again,
        printer: Printer,
    ) -> anyhow::Result<Status> {
        let Self { jobs, plan, at_a_time } = *self;
        if plan.is_none() {
            check_distinct(jobs)?;
            jobs.iter().try_for_each(Job::check)?;
        }
        let at_a_time = at_a_time.min(jobs.len());
        let out = jobs.first().and_then(|job| job.folder.parent()).unwrap_or(Path::new(""));
        std::fs::create_dir_all(out).map_err(FileError::write(out))?;
        let out = out.display();
        printer.note(format_args!("{} runs in {out}, {at_a_time} at a time", jobs.len()));
        let children = Children::new()?;
        let next = AtomicUsize::new(0);
        let ended = AtomicUsize::new(0);
        let failed = AtomicUsize::new(0);
        let elsewhere = AtomicUsize::new(0);
        // The status of a run that was asked to end, by this program or by someone else.
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let job = jobs.get(index)?;
                let outcome = self.do_one(index, again, &children).unwrap_or_else(|error| {
                    printer.error(&error, None);
                    Outcome::Failed
                });
                match outcome {
                    Outcome::Done => {}
                    Outcome::Failed => {
                        failed.fetch_add(1, Ordering::Relaxed);
                    }
                    Outcome::Elsewhere => {
                        elsewhere.fetch_add(1, Ordering::Relaxed);
                    }
                    Outcome::Interrupted(status) => {
                        next.store(jobs.len(), Ordering::Relaxed);
                        return Some(status);
                    }
                    Outcome::NotBegun => return None,
                }
                let ended = 1 + ended.fetch_add(1, Ordering::Relaxed);
                let found = Found::read(job);
                let found = found.map_or_else(|error| error.to_string(), |found| found.to_string());
                printer.note(format_args!("{ended}/{}  {}  {found}", jobs.len(), job.name()));
            }
        };
        let interrupted = thread::scope(|scope| {
            let workers: Vec<_> = (0..at_a_time).map(|_| scope.spawn(work)).collect();
            let join = |worker: thread::ScopedJoinHandle<'_, _>| {
                worker.join().expect("a worker does not panic")
            };
            workers.into_iter().map(join).fold(None, Option::or)
        });

        let (cells, unreadable) = summarize(jobs);
        if json {
            printer.data(&serde_json::to_string_pretty(&cells)?)?;
        } else {
            printer.data(&listing(&cells))?;
        }
        if let Some(status) = children.signal().map(Status::of_signal).or(interrupted) {
            printer.note("interrupted; the same command continues");
            return Ok(status);
        }
        let failed = failed.into_inner();
        anyhow::ensure!(
            failed == 0,
            "{failed} of {} runs failed; their errors are above",
            jobs.len()
        );
        // The table is without it.
        unreadable.map_or(Ok(()), |error| Err(anyhow::Error::from(error)))?;
        let elsewhere = elsewhere.into_inner();
        if elsewhere > 0 {
            printer.note(format_args!("{elsewhere} cells are being trained by other workers"));
            return Ok(Status::Busy);
        }
        Ok(Status::Success)
    }

    /// Begins a run, resumes it, or finds it finished.
    fn do_one(&self, index: usize, again: &Again, children: &Children) -> anyhow::Result<Outcome> {
        let job = &self.jobs[index];
        let (mut command, input) = match self.plan {
            Some(plan) if is_done(&job.folder, plan)? => return Ok(Outcome::Done),
            Some(plan) => (cell_command(again, plan, index), String::new()),
            None => job.command(again)?,
        };
        let child = children.start(&mut command).context("cannot start a run")?;
        let Some(mut child) = child else { return Ok(Outcome::NotBegun) };
        if let Some(mut stdin) = child.stdin.take() {
            // A run that ends before it has read its settings says why itself.
            let _ = stdin.write_all(input.as_bytes());
        }
        let status = children.wait(child).context("cannot wait for a run")?;
        Ok(match Status::of_interrupted(status) {
            Some(status) => Outcome::Interrupted(status),
            None if status.success() => Outcome::Done,
            None if status.code() == Some(Status::Busy as i32) => Outcome::Elsewhere,
            None => Outcome::Failed,
        })
    }
}

/// The command that trains a cell.
fn cell_command(again: &Again, plan: &Plan, cell: usize) -> Command {
    let mut command = again.command();
    command.args(["sweep", "--cell", &cell.to_string(), "--plan"]).arg(plan.path());
    command.args(["--parent", &std::process::id().to_string()]).stdin(Stdio::null());
    command
}

/// Whether the cell of a plan whose folder this is has been trained to its end.
fn is_done(folder: &Path, plan: &Plan) -> Result<bool, AttemptError> {
    let seen = look(folder)?.filter(|seen| seen.worker.plan == *plan.id());
    Ok(seen.and_then(|seen| seen.end).is_some_and(|end| end.status == Status::Success as u8))
}

/// How far a run came.
struct Found {
    is_solved: bool,
    last: Option<Evaluation>,
}

impl Found {
    fn read(job: &Job) -> Result<Self, MetricsError> {
        let evaluations = match read_evaluations(&job.folder, None) {
            Err(MetricsError::Missing { .. }) => Vec::new(),
            evaluations => evaluations?,
        };
        let rates: Vec<f32> =
            evaluations.iter().map(|evaluation| evaluation.success_final as f32).collect();
        let is_solved =
            rates.last_chunk().is_some_and(|last_two| job.settings.config.is_solved(*last_two));
        Ok(Self { is_solved, last: evaluations.last().cloned() })
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(last) = &self.last else { return f.write_str("not evaluated yet") };
        let word = if self.is_solved { "solved" } else { "success" };
        let success = percent(last.success_final);
        write!(f, "{word} {success} after {} steps", thousands(last.env_steps))
    }
}

/// All seeds of one cell.
#[derive(Serialize)]
struct Group<'a> {
    settings: &'a str,
    runs: usize,
    /// Runs that reached `until`.
    solved: usize,
    /// Median over those.
    steps: Option<u64>,
    /// Median over those.
    seconds: Option<f64>,
    /// Mean of the last evaluations.
    success: Option<f64>,
}

/// What was reached in each cell, and the first run that cannot be read, if there is one.
fn summarize(jobs: &[Job]) -> (Vec<Group<'_>>, Option<MetricsError>) {
    let mut unreadable = None;
    let mut read = |job: &Job| match Found::read(job) {
        Ok(found) => Some(found),
        Err(error) => {
            unreadable.get_or_insert(error);
            None
        }
    };
    let cells = jobs.chunk_by(|a, b| a.cell == b.cell).map(|jobs| {
        let found: Vec<_> = jobs.iter().filter_map(&mut read).collect();
        let solved = || found.iter().filter(|found| found.is_solved);
        let last = |found: &Found| found.last.clone();
        let measured: Vec<_> = found.iter().filter_map(last).collect();
        let success = measured.iter().map(|evaluation| evaluation.success_final);
        let seconds = solved().filter_map(last).map(|metrics| metrics.wall_s as u64);
        Group {
            settings: &jobs[0].cell,
            runs: jobs.len(),
            solved: solved().count(),
            steps: median(solved().filter_map(last).map(|metrics| metrics.env_steps).collect()),
            seconds: median(seconds.collect()).map(|seconds| seconds as f64),
            success: (!measured.is_empty()).then(|| success.sum::<f64>() / measured.len() as f64),
        }
    });
    let cells = cells.collect();
    (cells, unreadable)
}

/// The middle one, or the upper of two.
fn median(mut values: Vec<u64>) -> Option<u64> {
    values.sort_unstable();
    values.get(values.len() / 2).copied()
}

fn listing(cells: &[Group]) -> String {
    let mut listing = table();
    listing.set_header(["settings", "solved", "steps", "minutes", "success"]);
    let dash = || "–".to_owned();
    for Group { settings, runs, solved, steps, seconds, success } in cells {
        let settings = if settings.is_empty() { "(the preset's)" } else { settings };
        listing.add_row([
            settings.to_owned(),
            format!("{solved} of {runs}"),
            steps.map_or_else(dash, thousands),
            seconds.map_or_else(dash, |seconds| format!("{:.1}", seconds / 60.0)),
            success.map_or_else(dash, percent),
        ]);
    }
    text(&listing)
}
