//! `rher sweep`: a grid of runs, trained here or written down as a plan.

use super::cell;
use super::status;
use crate::cli::{SettingsArgs, SweepArgs};
use crate::errors::{NoCellNumber, RepeatedKey};
use crate::exit_code::Status;
use crate::host::Again;
use crate::host::threads;
use crate::jobs::{Job, Work, check_distinct};
use crate::printer::Printer;
use crate::values::Assignment;
use rher_envs::Task;
use rher_runs::settings;
use rher_runs::sweep::{Cell, Plan, from_plan};
use std::path::{Path, PathBuf};

pub(crate) fn sweep(args: &SweepArgs, again: &Again, printer: Printer) -> anyhow::Result<Status> {
    let (at_a_time, json) = (threads(args.runs.jobs), args.runs.json);
    if let Some(plan) = &args.status {
        return status::status(&Plan::read(plan)?, json, printer);
    }
    if !args.tasks.is_empty() {
        let out = args.out.clone().unwrap_or_else(|| default_folder(&args.tasks));
        let jobs = grid(args, &out)?;
        return match &args.plan {
            Some(plan) => write(plan, &jobs, printer),
            None => Work { jobs: &jobs, plan: None, at_a_time }.run(json, again, printer),
        };
    }
    let plan = args.plan.as_deref().expect("clap asks for a task, a plan or a status");
    let plan = Plan::read(plan)?;
    let number = args.cell_from.as_deref().map(number_from).transpose()?;
    if let Some(number) = args.cell.or(number) {
        return cell::cell(&plan, number, args, printer);
    }
    let jobs = plan.cells().iter().map(|cell| Job::of_plan(&plan, cell));
    let jobs = jobs.collect::<anyhow::Result<Vec<_>>>()?;
    Work { jobs: &jobs, plan: Some(&plan), at_a_time }.run(json, again, printer)
}

fn default_folder(tasks: &[Task]) -> PathBuf {
    let names: Vec<&str> = tasks.iter().map(|task| task.name()).collect();
    Path::new("runs").join(format!("sweep-{}", names.join("-")))
}

/// Writes the plan of these jobs.
fn write(path: &Path, jobs: &[Job], printer: Printer) -> anyhow::Result<Status> {
    check_distinct(jobs)?;
    let cell = |job: &Job| -> anyhow::Result<Cell> {
        let Job { cell, settings, folder, .. } = job.clone();
        Ok(Cell { group: cell, folder: from_plan(path, &folder)?, settings })
    };
    let plan = Plan::write(path, jobs.iter().map(cell).collect::<anyhow::Result<_>>()?)?;
    let last = plan.cells().len() - 1;
    let path = path.display();
    printer.note(format_args!(
        "{path}: cells 0 to {last}; `rher sweep --plan {path}` trains them here, and with \
         `--cell K` one of them anywhere"
    ));
    Ok(Status::Success)
}

/// The number of a cell in an environment variable.
fn number_from(variable: &str) -> Result<u64, NoCellNumber> {
    let found = std::env::var_os(variable).map(|value| value.to_string_lossy().into_owned());
    let number = found.as_deref().and_then(|value| value.trim().parse().ok());
    number.ok_or_else(|| NoCellNumber { variable: variable.to_owned(), found })
}

/// Every combination of tasks, values and seeds.
fn grid(args: &SweepArgs, out: &Path) -> anyhow::Result<Vec<Job>> {
    let keys: Vec<&str> = args.vary.iter().map(|axis| axis.key.as_str()).collect();
    if let Some(index) = (1..keys.len()).find(|&index| keys[..index].contains(&keys[index])) {
        return Err(RepeatedKey { key: keys[index].to_owned() }.into());
    }
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
    let job = |task: Task, varied: &[Assignment], seed| -> anyhow::Result<Job> {
        let asked = SettingsArgs {
            preset: args.preset,
            config: args.config.clone(),
            set: varied.to_vec(),
            method: args.method,
            seed: Some(seed),
            env_steps: args.env_steps,
            until: args.until,
            engine: None,
            precision: None,
            envs: None,
        };
        let settings = settings::resolve_here(task, &(&asked).into())?;
        let name = (args.tasks.len() > 1).then_some(task.name());
        Ok(Job::new(out, cell_name(name, varied), task, settings))
    };
    let mut jobs = Vec::new();
    for &task in &args.tasks {
        for varied in &combinations {
            for &seed in &args.seeds.0 {
                jobs.push(job(task, varied, seed)?);
            }
        }
    }
    Ok(jobs)
}

/// Such as `push relay.mirror=0.5 agent.hidden=[8,8]`; a sweep of one task does not name it.
fn cell_name(task: Option<&str>, varied: &[Assignment]) -> String {
    let parts = varied.iter().map(|a| format!("{}={}", a.key, a.value).replace(' ', ""));
    task.map(str::to_owned).into_iter().chain(parts).collect::<Vec<_>>().join(" ")
}
