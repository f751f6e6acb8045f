//! `rher sweep --status`: how far the cells of a plan are.

use crate::cells::{Row, State, rows};
use crate::exit_code::Status;
use crate::numbers::{duration, thousands};
use crate::printer::Printer;
use crate::tables::{table, text};
use rher_runs::sweep::Plan;
use serde::Serialize;

/// What is printed.
#[derive(Serialize)]
struct Overview {
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
    list: Vec<Row>,
}

pub(super) fn status(plan: &Plan, json: bool, printer: Printer) -> anyhow::Result<Status> {
    let overview = Overview::of(plan, rows(plan)?);
    if json {
        printer.data(&serde_json::to_string_pretty(&overview)?)?;
    } else {
        printer.data(&describe(&overview))?;
    }
    Ok(Status::Success)
}

impl Overview {
    fn of(plan: &Plan, list: Vec<Row>) -> Self {
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
        let rate = match row.state {
            State::Running => format!("{:.0}", row.steps_per_s),
            _ => String::new(),
        };
        listing.add_row([
            row.cell.to_string(),
            row.folder.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            row.state.name().to_owned(),
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
