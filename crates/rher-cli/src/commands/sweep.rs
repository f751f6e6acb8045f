//! `rher sweep`: a grid of runs, a few at a time, each in a process and a folder of its own.

use super::{table, text, threads};
use crate::cli::{Assignment, SettingsArgs, SweepArgs};
use crate::exit_code::Status;
use crate::observe::{percent, thousands};
use crate::printer::Printer;
use crate::run_dir::{self, RunDir, WriteError};
use crate::settings;
use anyhow::Context as _;
use rher_core::event::Metrics;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

pub(crate) fn sweep(args: &SweepArgs, printer: Printer) -> anyhow::Result<Status> {
    let runs = grid(args)?;
    let out =
        args.out.clone().unwrap_or_else(|| Path::new("runs").join(format!("sweep-{}", args.task)));
    std::fs::create_dir_all(&out).map_err(|source| WriteError { path: out.clone(), source })?;
    let jobs = threads(args.jobs).min(runs.len());
    printer.note(format_args!("{} runs in {}, {jobs} at a time", runs.len(), out.display()));
    // The first Ctrl-C reaches every run, which saves and ends; this process waits for them.
    ctrlc::set_handler(|| {}).context("cannot listen to Ctrl-C")?;

    let next = AtomicUsize::new(0);
    let ended = AtomicUsize::new(0);
    let work = || -> anyhow::Result<Vec<(usize, ExitStatus)>> {
        let mut statuses = Vec::new();
        while let Some(run) = runs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let index = run.index;
            let folder = out.join(run.name());
            let status = run.train(args, &folder)?;
            statuses.push((index, status));
            let ended = 1 + ended.fetch_add(1, Ordering::Relaxed);
            let found = Found::read(&folder);
            printer.note(format_args!("{ended}/{}  {}  {found}", runs.len(), run.name()));
            if status.code() == Some(Status::Interrupted as i32) {
                next.store(runs.len(), Ordering::Relaxed);
            }
        }
        Ok(statuses)
    };
    let statuses: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join().expect("a worker does not panic")).collect()
    });
    let statuses = statuses.into_iter().collect::<anyhow::Result<Vec<_>>>()?.concat();

    let summary = summarise(&runs, &out);
    if args.json {
        printer.data(&serde_json::to_string_pretty(&summary)?)?;
    } else {
        printer.data(&listing(&summary))?;
    }
    let interrupted = statuses.len() < runs.len()
        || statuses.iter().any(|(_, status)| status.code() == Some(Status::Interrupted as i32));
    if interrupted {
        printer.note("interrupted; the same command goes on");
        return Ok(Status::Interrupted);
    }
    let failed = statuses.iter().filter(|(_, status)| !status.success()).count();
    anyhow::ensure!(failed == 0, "{failed} of {} runs failed; their errors are above", runs.len());
    Ok(Status::Success)
}

/// One run of the grid.
#[derive(Clone, Debug)]
struct Run {
    index: usize,
    /// What `--set` says with several values, one of each.
    varied: Vec<Assignment>,
    seed: u64,
}

/// Every combination of values and seeds, once its settings are known to be good.
fn grid(args: &SweepArgs) -> anyhow::Result<Vec<Run>> {
    let mut combinations = vec![Vec::new()];
    for axis in &args.vary {
        combinations = combinations
            .iter()
            .flat_map(|before| {
                axis.values.iter().map(|value| {
                    let assignment = Assignment { key: axis.key.clone(), value: value.clone() };
                    [before.as_slice(), &[assignment]].concat()
                })
            })
            .collect();
    }
    let seeds = &args.seeds.0;
    let runs = combinations
        .into_iter()
        .flat_map(|varied| seeds.iter().map(move |&seed| (varied.clone(), seed)))
        .enumerate()
        .map(|(index, (varied, seed))| Run { index, varied, seed })
        .collect::<Vec<_>>();
    for run in &runs {
        settings::resolve(args.task, &run.settings(args))?;
    }
    Ok(runs)
}

impl Run {
    /// Such as `relay.mirror=0.5,seed=1`.
    fn name(&self) -> String {
        let varied = self.varied.iter().map(|Assignment { key, value }| format!("{key}={value},"));
        let name = varied.collect::<String>() + &format!("seed={}", self.seed);
        name.replace(['"', ' '], "").replace('/', "_")
    }

    fn settings(&self, args: &SweepArgs) -> SettingsArgs {
        SettingsArgs {
            preset: args.preset,
            config: args.config.clone(),
            set: self.varied.clone(),
            method: args.method,
            seed: Some(self.seed),
            env_steps: args.env_steps,
            until: args.until,
            engine: None,
            envs: None,
        }
    }

    /// Begins the run, goes on with it, or finds it finished.
    fn train(&self, args: &SweepArgs, folder: &Path) -> anyhow::Result<ExitStatus> {
        let program = std::env::current_exe().context("cannot find this program's own file")?;
        let mut command = Command::new(program);
        command.args(["train", "--quiet", "--workers", "1"]).stdin(Stdio::null());
        if RunDir::open(folder).is_ok() {
            command.arg("--resume").arg(folder);
        } else {
            command.arg(args.task.name()).arg("--out").arg(folder);
            command.arg("--seed").arg(self.seed.to_string());
            let SettingsArgs { preset, config, method, .. } = self.settings(args);
            let preset = preset.map(|preset| preset.name().to_owned());
            let method = method.map(|method| method.name().to_owned());
            let config = config.map(PathBuf::into_os_string);
            for (option, value) in [
                ("--preset", preset.map(Into::into)),
                ("--method", method.map(Into::into)),
                ("--config", config),
            ] {
                command.args(value.map(|value| [option.into(), value]).into_iter().flatten());
            }
            for Assignment { key, value } in &self.varied {
                command.arg("--set").arg(format!("{key}={value}"));
            }
        }
        for (option, value) in [
            ("--env-steps", args.env_steps.map(|steps| steps.to_string())),
            ("--until", args.until.map(|rate| rate.to_string())),
        ] {
            command.args(value.map(|value| [option.to_owned(), value]).into_iter().flatten());
        }
        command.status().context("cannot start a run")
    }
}

/// How far a run came.
struct Found {
    until: f32,
    last: Option<Metrics>,
    before: Option<Metrics>,
}

impl Found {
    fn read(folder: &Path) -> Self {
        let until = run_dir::read_config(folder).map_or(0.0, |run| run.config.until);
        let mut metrics = run_dir::read_metrics(folder);
        Self { until, last: metrics.pop(), before: metrics.pop() }
    }

    fn is_solved(&self) -> bool {
        let good = |metrics: &Option<Metrics>| {
            metrics.as_ref().is_some_and(|metrics| metrics.success_final >= self.until)
        };
        self.until > 0.0 && good(&self.last) && good(&self.before)
    }
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(last) = &self.last else { return f.write_str("nothing measured") };
        let word = if self.is_solved() { "solved" } else { "success" };
        let success = percent(last.success_final.into());
        write!(f, "{word} {success} after {} steps", thousands(last.env_steps))
    }
}

/// All seeds of one combination of settings.
#[derive(Serialize)]
struct Cell {
    settings: String,
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

fn summarise(runs: &[Run], out: &Path) -> Vec<Cell> {
    let same = |a: &Run, b: &Run| a.varied == b.varied;
    runs.chunk_by(same)
        .map(|runs| {
            let found: Vec<_> = runs.iter().map(|run| Found::read(&out.join(run.name()))).collect();
            let solved = || found.iter().filter(|found| found.is_solved());
            let last = |found: &Found| found.last.clone();
            let measured: Vec<_> = found.iter().filter_map(last).collect();
            let success = measured.iter().map(|metrics| f64::from(metrics.success_final));
            let varied = runs[0].varied.iter().map(|a| format!("{}={}", a.key, a.value));
            Cell {
                settings: varied.collect::<Vec<_>>().join(" "),
                runs: runs.len(),
                solved: solved().count(),
                steps: median(solved().filter_map(last).map(|metrics| metrics.env_steps).collect()),
                seconds: median(
                    solved().filter_map(last).map(|metrics| metrics.wall_s as u64).collect(),
                )
                .map(|seconds| seconds as f64),
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
