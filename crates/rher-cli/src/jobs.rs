//! Many runs, a few at a time, each in a process and a folder of its own.

use crate::cli::SettingsArgs;
use crate::commands::{table, text};
use crate::exit_code::Status;
use crate::observe::{percent, thousands};
use crate::printer::Printer;
use crate::runs::{Evaluation, read_evaluations};
use crate::values::Assignment;
use anyhow::Context as _;
use rher_core::files::FileError;
use rher_envs::Task;
use rher_runs::{RunDir, read_config, settings};
use serde::Serialize;
use std::ffi::OsString;
use std::fmt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// One run.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// What it is one of several seeds of; jobs of one cell stand together.
    pub(crate) cell: String,
    pub(crate) task: Task,
    pub(crate) settings: SettingsArgs,
}

impl Job {
    /// Name of its folder, such as `relay.mirror=0.5,seed=1`.
    pub(crate) fn name(&self) -> String {
        let seed = format!("seed={}", self.settings.seed.unwrap_or(1));
        let parts: Vec<_> = self.cell.split_whitespace().chain([seed.as_str()]).collect();
        parts.join(",").replace('"', "").replace('/', "_")
    }

    /// Begins the run, goes on with it, or finds it finished.
    fn train(&self, folder: &Path) -> anyhow::Result<ExitStatus> {
        let program = std::env::current_exe().context("cannot find this program's own file")?;
        let mut command = Command::new(program);
        command.args(["train", "--quiet", "--workers", "1"]).stdin(Stdio::null());
        let SettingsArgs { env_steps, until, .. } = self.settings;
        if RunDir::open(folder).is_ok() {
            command.arg("--resume").arg(folder);
        } else {
            command.arg(self.task.name()).arg("--out").arg(folder);
            let SettingsArgs { preset, config, set, method, seed, envs, .. } = &self.settings;
            let options = [
                ("--preset", preset.map(|preset| preset.name().into())),
                ("--method", method.map(|method| method.name().into())),
                ("--config", config.clone().map(Into::into)),
                ("--seed", seed.map(|seed| seed.to_string().into())),
                ("--envs", envs.map(|envs| envs.to_string().into())),
            ];
            add(&mut command, options);
            for Assignment { key, value } in set {
                command.arg("--set").arg(format!("{key}={value}"));
            }
        }
        let options = [
            ("--env-steps", env_steps.map(|steps| steps.to_string().into())),
            ("--until", until.map(|rate| rate.to_string().into())),
        ];
        add(&mut command, options);
        command.status().context("cannot start a run")
    }
}

fn add<const K: usize>(command: &mut Command, options: [(&str, Option<OsString>); K]) {
    for (name, value) in options {
        if let Some(value) = value {
            command.arg(name).arg(value);
        }
    }
}

/// Does all jobs, `at_a_time` of them at a time, in folders of `out`, and prints what came of them.
///
/// Done again, it goes on with runs that were interrupted and leaves finished ones alone.
pub(crate) fn run(
    jobs: &[Job],
    at_a_time: usize,
    out: &Path,
    json: bool,
    printer: Printer,
) -> anyhow::Result<Status> {
    for Job { task, settings, .. } in jobs {
        settings::resolve(*task, &settings.into())?;
    }
    std::fs::create_dir_all(out).map_err(FileError::write(out))?;
    let at_a_time = at_a_time.min(jobs.len());
    printer.note(format_args!("{} runs in {}, {at_a_time} at a time", jobs.len(), out.display()));
    // The first Ctrl-C reaches every run, which saves and ends; this process waits for them.
    ctrlc::set_handler(|| {}).context("cannot listen to Ctrl-C")?;

    let next = AtomicUsize::new(0);
    let ended = AtomicUsize::new(0);
    let work = || -> anyhow::Result<Vec<ExitStatus>> {
        let mut statuses = Vec::new();
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = job.name();
            let folder = out.join(&name);
            let status = job.train(&folder)?;
            statuses.push(status);
            let ended = 1 + ended.fetch_add(1, Ordering::Relaxed);
            printer.note(format_args!("{ended}/{}  {name}  {}", jobs.len(), Found::read(&folder)));
            if is_interrupted(status) {
                next.store(jobs.len(), Ordering::Relaxed);
            }
        }
        Ok(statuses)
    };
    let statuses: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..at_a_time).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join().expect("a worker does not panic")).collect()
    });
    let statuses = statuses.into_iter().collect::<anyhow::Result<Vec<_>>>()?.concat();

    let cells = summarise(jobs, out);
    if json {
        printer.data(&serde_json::to_string_pretty(&cells)?)?;
    } else {
        printer.data(&listing(&cells))?;
    }
    if statuses.len() < jobs.len() || statuses.iter().copied().any(is_interrupted) {
        printer.note("interrupted; the same command goes on");
        return Ok(Status::Interrupted);
    }
    let failed = statuses.iter().filter(|status| !status.success()).count();
    anyhow::ensure!(failed == 0, "{failed} of {} runs failed; their errors are above", jobs.len());
    Ok(Status::Success)
}

fn is_interrupted(status: ExitStatus) -> bool {
    status.code() == Some(Status::Interrupted as i32)
}

/// How far a run came.
struct Found {
    until: f32,
    last: Option<Evaluation>,
    before: Option<Evaluation>,
}

impl Found {
    fn read(folder: &Path) -> Self {
        let until = read_config(folder).map_or(0.0, |run| run.config.until);
        let mut evaluations = read_evaluations(folder).unwrap_or_default();
        Self { until, last: evaluations.pop(), before: evaluations.pop() }
    }

    fn is_solved(&self) -> bool {
        let good = |evaluation: &Option<Evaluation>| {
            evaluation.as_ref().is_some_and(|evaluation| evaluation.reaches(self.until.into()))
        };
        self.until > 0.0 && good(&self.last) && good(&self.before)
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(last) = &self.last else { return f.write_str("nothing measured") };
        let word = if self.is_solved() { "solved" } else { "success" };
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

fn summarise<'a>(jobs: &'a [Job], out: &Path) -> Vec<Cell<'a>> {
    jobs.chunk_by(|a, b| a.cell == b.cell)
        .map(|jobs| {
            let found: Vec<_> = jobs.iter().map(|job| Found::read(&out.join(job.name()))).collect();
            let solved = || found.iter().filter(|found| found.is_solved());
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
                success: (!measured.is_empty())
                    .then(|| success.sum::<f64>() / measured.len() as f64),
            }
        })
        .collect()
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
