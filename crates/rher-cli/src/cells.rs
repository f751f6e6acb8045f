//! The cells of a plan as they are now.

use crate::exit_code::Status;
use rher_runs::sweep::{Beat, Cell, End, Life, Plan, Seen, look};
use rher_runs::{ConfigFile, MetricsError, OtherSettings, difference, read_evaluations};
use serde::Serialize;
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

/// How long workers on other machines are watched for a sign of life: they give one each second.
const WATCHED: Duration = Duration::from_secs(4);

/// A cell.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) cell: usize,
    pub(crate) task: String,
    pub(crate) seed: u64,
    pub(crate) group: String,
    pub(crate) folder: PathBuf,
    pub(crate) state: State,
    pub(crate) env_steps: u64,
    pub(crate) steps_per_s: f64,
    /// Who trains it, or trained it last.
    pub(crate) worker: Option<String>,
    /// Exit status of the last attempt, if it has ended by itself.
    pub(crate) status: Option<u8>,
    /// Why it has failed or stopped.
    pub(crate) why: Option<String>,
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum State {
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

/// Every cell of a plan, in the order of their numbers.
pub(crate) fn rows(plan: &Plan) -> anyhow::Result<Vec<Row>> {
    let look_at = |cell: &Cell| look(&plan.folder(cell));
    let seen = plan.cells().iter().map(look_at).collect::<Result<Vec<_>, _>>()?;
    let is_unsure = |seen: &Option<Seen>| {
        seen.as_ref().is_some_and(|seen| seen.end.is_none() && seen.life == Life::Unknown)
    };
    if seen.iter().any(is_unsure) {
        thread::sleep(WATCHED);
    }
    let mut rows = Vec::new();
    for (number, (cell, before)) in plan.cells().iter().zip(seen).enumerate() {
        let now = if is_unsure(&before) { look_at(cell)? } else { before.clone() };
        rows.push(row(plan, number, cell, before.map(|seen| seen.beat), now));
    }
    Ok(rows)
}

fn row(plan: &Plan, number: usize, cell: &Cell, before: Option<Beat>, now: Option<Seen>) -> Row {
    let config = &cell.settings.config;
    let mut row = Row {
        cell: number,
        task: config.task.clone(),
        seed: config.seed,
        group: cell.group.clone(),
        folder: cell.folder.clone(),
        state: State::Waiting,
        env_steps: 0,
        steps_per_s: 0.0,
        worker: None,
        status: None,
        why: None,
    };
    let Some(Seen { worker, beat, end, life, .. }) = now else {
        (row.state, row.env_steps, row.why) = without_worker(plan, cell);
        return row;
    };
    row.env_steps = beat.env_steps;
    row.worker = Some(worker.to_string());
    if (&worker.plan, worker.cell) != (plan.id(), number) {
        row.state = State::Failed;
        row.why =
            Some(format!("its folder belongs to cell {} of plan {}", worker.cell, worker.plan));
        return row;
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
    row
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
fn without_worker(plan: &Plan, cell: &Cell) -> (State, u64, Option<String>) {
    if let Some(why) = other_run(plan, cell) {
        return (State::Failed, 0, Some(why));
    }
    let config = &cell.settings.config;
    let evaluations = match read_evaluations(&plan.folder(cell), None) {
        Err(MetricsError::Missing { .. }) => return (State::Waiting, 0, None),
        Err(error) => return (State::Failed, 0, Some(error.to_string())),
        Ok(evaluations) => evaluations,
    };
    let env_steps = evaluations.last().map_or(0, |evaluation| evaluation.env_steps);
    let rates: Vec<f32> =
        evaluations.iter().map(|evaluation| evaluation.success_final as f32).collect();
    let is_solved = rates.last_chunk().is_some_and(|last_two| config.is_solved(*last_two));
    let is_done = is_solved || env_steps >= config.env_steps;
    (if is_done { State::Done } else { State::Stopped }, env_steps, None)
}

/// Why what is in the folder of a cell is not its run.
fn other_run(plan: &Plan, cell: &Cell) -> Option<String> {
    let folder = plan.folder(cell);
    let found = match ConfigFile::read(&folder) {
        Ok(file) => file?.settings(),
        Err(error) => Err(error),
    };
    let found = match found {
        Ok(found) => found,
        Err(error) => return Some(error.to_string()),
    };
    match difference(&found, &cell.settings) {
        Ok(None) => None,
        Ok(Some((key, found, asked))) => {
            Some(OtherSettings { folder, key, found, asked }.to_string())
        }
        Err(error) => Some(error.to_string()),
    }
}

impl State {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Running => "running",
            Self::Stopped => "stopped",
            Self::Failed => "failed",
            Self::Done => "done",
        }
    }
}
