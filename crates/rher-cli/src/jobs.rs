//! Many runs, a few at a time, each in a process and a folder of its own.

use crate::children::Children;
use crate::errors::SameRun;
use crate::exit_code::Status;
use crate::host::Program;
use crate::numbers::{percent, thousands};
use crate::printer::Printer;
use crate::tables::{table, text};
use crate::trained::made_with;
use anyhow::Context as _;
use rher_core::files::FileError;
use rher_core::train::checkpoint::{self, CheckpointError};
use rher_envs::Task;
use rher_runs::{
    Evaluation, MetricsError, OtherSettings, Settings, difference, read_evaluations, settings,
};
use serde::Serialize;
use sha2::{Digest as _, Sha256};
use std::collections::HashMap;
use std::fmt;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
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
}

impl Job {
    /// Name of its folder, such as `relay.mirror=0.5,seed=1`; a name that is too long is cut, and
    /// ends with a hash of all of it.
    pub(crate) fn name(&self) -> String {
        let seed = format!("seed={}", self.settings.config.seed);
        let parts: Vec<_> = self.cell.split_whitespace().chain([seed.as_str()]).collect();
        let name = parts.join(",").replace('"', "").replace('/', "_");
        if name.len() <= LONGEST_NAME {
            return name;
        }
        let hash: String = Sha256::digest(&name)[..8]
            .iter()
            .fold(String::new(), |text, byte| text + &format!("{byte:02x}"));
        let end = name.floor_char_boundary(LONGEST_NAME - hash.len() - 1);
        format!("{}-{hash}", &name[..end])
    }

    /// The command that begins the run in `folder` or resumes it, and what it reads.
    fn command(&self, folder: &Path, program: &Program) -> anyhow::Result<(Command, String)> {
        let mut command = program.command();
        let parent = std::process::id().to_string();
        command.args(["train", "--quiet", "--workers", "1", "--parent", &parent]);
        let config = &self.settings.config;
        if holds_run(folder)? {
            let (env_steps, until) = (config.env_steps.to_string(), config.until.to_string());
            command.arg("--resume").arg(folder);
            command.args(["--env-steps", &env_steps, "--until", &until]);
            command.stdin(Stdio::null());
            return Ok((command, String::new()));
        }
        command.arg(self.task.name()).arg("--out").arg(folder);
        command.args(["--config", "/dev/stdin"]).stdin(Stdio::piped());
        Ok((command, settings::to_toml(&self.settings)?))
    }

    /// Begins the run, resumes it, or finds it finished; `None` if this program was asked to end.
    fn train(
        &self,
        folder: &Path,
        program: &Program,
        children: &Children,
    ) -> anyhow::Result<Option<ExitStatus>> {
        let (mut command, input) = self.command(folder, program)?;
        let child = children.start(&mut command).context("cannot start a run")?;
        let Some(mut child) = child else { return Ok(None) };
        if let Some(mut stdin) = child.stdin.take() {
            // A run that ends before it has read its settings says why itself.
            let _ = stdin.write_all(input.as_bytes());
        }
        Ok(Some(children.wait(child).context("cannot wait for a run")?))
    }

    /// Whether the run in `folder`, if there is one, is this one.
    fn check(&self, folder: &Path) -> anyhow::Result<()> {
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

/// Takes no lock, which could keep another process from training that run.
fn holds_run(folder: &Path) -> Result<bool, CheckpointError> {
    match checkpoint::read_config(folder) {
        Err(CheckpointError::Missing { .. }) => Ok(false),
        config => config.map(|_| true),
    }
}

/// No two jobs are the same run, and none differs from the run in its folder.
fn check(jobs: &[Job], out: &Path) -> anyhow::Result<()> {
    let mut known = HashMap::new();
    for job in jobs {
        let text = settings::to_toml(&job.settings)?;
        if let Some(first) = known.insert(text, &job.cell) {
            let (first, second) = (first.clone(), job.cell.clone());
            return Err(SameRun { first, second }.into());
        }
    }
    jobs.iter().try_for_each(|job| job.check(&out.join(job.name())))
}

/// Does all jobs, `at_a_time` of them at a time, in folders of `out`, and prints their results.
///
/// Done again, it resumes runs that were interrupted and does not touch finished ones.
pub(crate) fn run(
    jobs: &[Job],
    at_a_time: usize,
    out: &Path,
    json: bool,
    program: &Program,
    printer: Printer,
) -> anyhow::Result<Status> {
    check(jobs, out)?;
    std::fs::create_dir_all(out).map_err(FileError::write(out))?;
    let at_a_time = at_a_time.min(jobs.len());
    printer.note(format_args!("{} runs in {}, {at_a_time} at a time", jobs.len(), out.display()));
    let children = Children::new()?;
    let next = AtomicUsize::new(0);
    let ended = AtomicUsize::new(0);
    let failed = AtomicUsize::new(0);
    // The status of a run that was asked to end, by this program or by someone else.
    let work = || {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = job.name();
            let folder = out.join(&name);
            match job.train(&folder, program, &children) {
                Ok(None) => return None,
                Ok(Some(status)) if status.success() => {}
                Ok(Some(status)) => {
                    if let Some(status) = Status::of_interrupted(status) {
                        next.store(jobs.len(), Ordering::Relaxed);
                        return Some(status);
                    }
                    failed.fetch_add(1, Ordering::Relaxed);
                }
                Err(error) => {
                    printer.error(&error, None);
                    failed.fetch_add(1, Ordering::Relaxed);
                }
            }
            let ended = 1 + ended.fetch_add(1, Ordering::Relaxed);
            let found = Found::read(&folder, job);
            let found = found.map_or_else(|error| error.to_string(), |found| found.to_string());
            printer.note(format_args!("{ended}/{}  {name}  {found}", jobs.len()));
        }
        None
    };
    let interrupted = thread::scope(|scope| {
        let workers: Vec<_> = (0..at_a_time).map(|_| scope.spawn(work)).collect();
        let join = |worker: thread::ScopedJoinHandle<'_, _>| {
            worker.join().expect("a worker does not panic")
        };
        workers.into_iter().map(join).fold(None, Option::or)
    });

    let (cells, unreadable) = summarize(jobs, out);
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
    anyhow::ensure!(failed == 0, "{failed} of {} runs failed; their errors are above", jobs.len());
    // The table is without it.
    unreadable.map_or(Ok(Status::Success), |error| Err(error.into()))
}

/// How far a run came.
struct Found {
    is_solved: bool,
    last: Option<Evaluation>,
}

impl Found {
    fn read(folder: &Path, job: &Job) -> Result<Self, MetricsError> {
        let evaluations = match read_evaluations(folder, None) {
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
struct Cell<'a> {
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
fn summarize<'a>(jobs: &'a [Job], out: &Path) -> (Vec<Cell<'a>>, Option<MetricsError>) {
    let mut unreadable = None;
    let mut read = |job: &Job| match Found::read(&out.join(job.name()), job) {
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
        Cell {
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

fn listing(cells: &[Cell]) -> String {
    let mut listing = table();
    listing.set_header(["settings", "solved", "steps", "minutes", "success"]);
    let dash = || "–".to_owned();
    for Cell { settings, runs, solved, steps, seconds, success } in cells {
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
