//! `rher sweep --cell`: one run of a plan, to its end.

use super::train::{Limits, train_cell};
use crate::cli::SweepArgs;
use crate::errors;
use crate::exit_code::Status;
use crate::host::end_with_parent;
use crate::jobs::Job;
use crate::printer::Printer;
use rher_runs::sweep::{Claim, End, PATIENCE, Plan};

/// Begins the cell with this number, continues it, or finds it done.
pub(crate) fn cell(
    plan: &Plan,
    number: u64,
    args: &SweepArgs,
    printer: Printer,
) -> anyhow::Result<Status> {
    if args.parent.is_some_and(|parent| !end_with_parent(parent)) {
        return Ok(Status::Terminated);
    }
    let (number, cell) = plan.cell(number)?;
    let job = Job::of_plan(plan, cell)?;
    let folder = &job.folder;
    let wait = |worker: &_| {
        let seconds = PATIENCE.as_secs();
        printer.note(format_args!(
            "cell {number} was begun by {worker}; waiting up to {seconds} s for a sign of it"
        ));
    };
    let Some(claim) = Claim::take(folder, plan.id(), number, PATIENCE, wait)? else {
        printer.note(format_args!("cell {number} is done already: {}", folder.display()));
        return Ok(Status::Success);
    };
    let limits = Limits { workers: args.workers, max_wall: args.max_wall };
    let trained = job.check().and_then(|()| train_cell(&job, &claim, limits, printer));
    let end = match &trained {
        Ok(status) => End { status: *status as u8, error: None },
        Err(error) => {
            let status = errors::report(error).status as u8;
            End { status, error: Some(format!("{error:#}")) }
        }
    };
    claim.end(&end)?;
    trained
}
