//! `rher sweep --status`: how far the cells of a plan are.

use crate::exit_code::Status;
use crate::numbers::{duration, thousands};
use crate::printer::Printer;
use crate::tables::{table, text};
use rher_runs::sweep::{Beat, Cell, End, Life, Plan, Seen, look};
use rher_runs::{MetricsError, read_evaluations};
use serde::Serialize;
use std::path::Path;
use std::thread;
use std::time::Duration;

/// How long workers on other machines are watched for a sign of life: they give one each second.
const WATCHED: Duration = Duration::from_secs(4);

/// What is printed.
#[derive(Serialize)]
struct Overview<'a> {
    plan: String,
    cells: usize,
    done: usize,
    running: usize,
    stopped: usize,
    failed: usize,
    waiting: usize,
    /// Of all cells that are running.
    steps_per_s: f64,
    /// At this rate until every cell has taken all of its steps; those that succeed end before.
    seconds_left: Option<f64>,
    list: Vec<Row<'a>>,
}

/// A cell.
#[derive(Serialize)]
struct Row<'a> {
    cell: usize,
    task: &'a str,
    seed: u64,
    group: &'a str,
    folder: &'a Path,
    state: State,
    env_steps: u64,
    steps_per_s: f64,
    /// Who trains it, or trained it last.
    worker: Option<String>,
    /// Exit status of the last attempt, if it has ended by itself.
    status: Option<u8>,
    /// Why it has failed or stopped.
    why: Option<String>,
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum State {
    /// Nobody has begun.
    Waiting,
    /// A worker trains it.
    Running,
    /// It was begun, and nobody trains it.
    Stopped,
    /// The last attempt ended with an error.
    Failed,
    /// It is at its end.
    Done,
}

pub(super) fn status(plan: &Plan, json: bool, printer: Printer) -> anyhow::Result<Status> {
    let look_at = |cell: &Cell| look(&plan.folder(cell));
    let seen = plan.cells().iter().map(look_at).collect::<Result<Vec<_>, _>>()?;
    let is_unsure = |seen: &Option<Seen>| {
        seen.as_ref().is_some_and(|seen| seen.end.is_none() && seen.life == Life::Unknown)
    };
    if seen.iter().any(is_unsure) {
        thread::sleep(WATCHED);
    }
    let mut list = Vec::new();
    for (number, (cell, before)) in plan.cells().iter().zip(seen).enumerate() {
        let now = if is_unsure(&before) { look_at(cell)? } else { before.clone() };
        list.push(row(plan, number, cell, before.map(|seen| seen.beat), now)?);
    }
    let overview = Overview::of(plan, list);
    if json {
        printer.data(&serde_json::to_string_pretty(&overview)?)?;
    } else {
        printer.data(&describe(&overview))?;
    }
    Ok(Status::Success)
}

fn row<'a>(
    plan: &Plan,
    number: usize,
    cell: &'a Cell,
    before: Option<Beat>,
    now: Option<Seen>,
) -> anyhow::Result<Row<'a>> {
    let config = &cell.settings.config;
    let mut row = Row {
        cell: number,
        task: &config.task,
        seed: config.seed,
        group: &cell.group,
        folder: &cell.folder,
        state: State::Waiting,
        env_steps: 0,
        steps_per_s: 0.0,
        worker: None,
        status: None,
        why: None,
    };
    let Some(Seen { worker, beat, end, life, .. }) = now else {
        (row.state, row.env_steps) = without_worker(plan, cell)?;
        return Ok(row);
    };
    row.env_steps = beat.env_steps;
    row.worker = Some(worker.to_string());
    if (&worker.plan, worker.cell) != (plan.id(), number) {
        row.state = State::Failed;
        row.why =
            Some(format!("its folder belongs to cell {} of plan {}", worker.cell, worker.plan));
        return Ok(row);
    }
    let is_alive = life == Life::Locked || life == Life::Unknown && before != Some(beat);
    match end {
        Some(End { status, error }) => {
            row.status = Some(status);
            row.state = state_of(status);
            row.why = error;
        }
        None if is_alive => {
            row.state = State::Running;
            row.steps_per_s = beat.steps_per_s;
        }
        None => {
            row.state = State::Stopped;
            row.why = Some(match life {
                Life::Unknown => "its worker gives no sign of life".to_owned(),
                _ => "its worker was killed".to_owned(),
            });
        }
    }
    Ok(row)
}

/// What an attempt that ended with this exit status left.
fn state_of(status: u8) -> State {
    const SAVED: [Status; 4] =
        [Status::TimeSpent, Status::HungUp, Status::Interrupted, Status::Terminated];
    if status == Status::Success as u8 {
        State::Done
    } else if SAVED.into_iter().any(|saved| saved as u8 == status) {
        State::Stopped
    } else {
        State::Failed
    }
}

/// The state of a cell that no worker of the plan has begun, and its steps: the run may have been
/// made otherwise.
fn without_worker(plan: &Plan, cell: &Cell) -> Result<(State, u64), MetricsError> {
    let evaluations = match read_evaluations(&plan.folder(cell), None) {
        Err(MetricsError::Missing { .. }) => return Ok((State::Waiting, 0)),
        evaluations => evaluations?,
    };
    let last = evaluations.last().map_or(0, |evaluation| evaluation.env_steps);
    Ok((State::Stopped, last))
}

impl<'a> Overview<'a> {
    fn of(plan: &Plan, list: Vec<Row<'a>>) -> Self {
        let count = |state| list.iter().filter(|row| row.state == state).count();
        let steps_per_s: f64 = list.iter().map(|row| row.steps_per_s).sum();
        let left = list.iter().zip(plan.cells()).filter(|(row, _)| row.state != State::Done);
        let left: u64 = left
            .map(|(row, cell)| cell.settings.config.env_steps.saturating_sub(row.env_steps))
            .sum();
        Self {
            plan: plan.id().to_string(),
            cells: list.len(),
            done: count(State::Done),
            running: count(State::Running),
            stopped: count(State::Stopped),
            failed: count(State::Failed),
            waiting: count(State::Waiting),
            steps_per_s,
            seconds_left: (steps_per_s > 0.0).then(|| left as f64 / steps_per_s),
            list,
        }
    }
}

fn describe(overview: &Overview) -> String {
    let Overview { cells, done, running, stopped, failed, waiting, steps_per_s, .. } = overview;
    let mut listing = table();
    listing.set_header(["cell", "run", "state", "steps", "steps/s", "worker", "why"]);
    for row in overview.list.iter().filter(|row| row.state != State::Done) {
        let state = match row.state {
            State::Waiting => "waiting",
            State::Running => "running",
            State::Stopped => "stopped",
            State::Failed => "failed",
            State::Done => "done",
        };
        let rate = match row.state {
            State::Running => format!("{:.0}", row.steps_per_s),
            _ => String::new(),
        };
        listing.add_row([
            row.cell.to_string(),
            row.folder.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            state.to_owned(),
            thousands(row.env_steps),
            rate,
            row.worker.clone().unwrap_or_default(),
            row.why.clone().unwrap_or_default(),
        ]);
    }
    let left = overview.seconds_left.map_or_else(String::new, |seconds| {
        format!(", at most {} for the steps that are left", duration(seconds))
    });
    let sum = format!(
        "{cells} cells: {done} done, {running} running, {stopped} stopped, {failed} failed, \
         {waiting} waiting\n{} steps/s{left}\n",
        thousands(*steps_per_s as u64)
    );
    if listing.is_empty() { sum } else { format!("{}\n{sum}", text(&listing)) }
}
