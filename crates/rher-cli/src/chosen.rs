//! The runs that a command is to compare: folders of runs, and plans with all of their cells.

use crate::cells::{Row, State, rows};
use crate::numbers::thousands;
use crate::printer::Printer;
use crate::running::note_evaluations;
use crate::shipped;
use crate::tables::table;
use comfy_table::Table;
use rher_runs::sweep::Plan;
use rher_runs::{Group, Groups, Repeated, Run, RunError};
use std::path::PathBuf;

/// Runs that were chosen, read once.
pub(crate) struct Chosen {
    pub(crate) groups: Vec<(Group, Vec<Run>)>,
    /// Cells of plans that are not at their end; those that were evaluated are in the groups, too.
    pub(crate) unfinished: Vec<Row>,
}

impl Chosen {
    /// Reads folders of runs, and plans. Folders that hold a run that counts already are left out,
    /// and so are cells without an evaluation.
    ///
    /// # Errors
    ///
    /// If no folder holds a run that was evaluated, or if something is not there or damaged.
    pub(crate) fn read(paths: &[PathBuf], printer: Printer) -> anyhow::Result<Self> {
        let (mut runs, mut unfinished, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for path in paths {
            let path = &*shipped::folder(path, printer)?;
            if !path.is_file() {
                note_evaluations(path, printer);
                match Run::read(path) {
                    // `runs/*` also names folders of sweeps, and runs that have only begun.
                    Err(error @ (RunError::Missing { .. } | RunError::NoMetrics { .. }))
                        if path.is_dir() =>
                    {
                        left_out.push(error);
                    }
                    run => runs.push(run?),
                }
                continue;
            }
            let plan = Plan::read(path)?;
            for (cell, mut row) in plan.cells().iter().zip(rows(&plan)?) {
                match Run::read(&plan.folder(cell)) {
                    Ok(mut run) => {
                        let varied = cell.group.strip_prefix(&run.group.task);
                        let varied = varied.unwrap_or(&cell.group).trim();
                        if !varied.is_empty() {
                            run.group.preset = format!("{} {varied}", run.group.preset);
                        }
                        runs.push(run);
                    }
                    Err(RunError::Missing { .. } | RunError::NoMetrics { .. }) => {}
                    Err(error) => {
                        row.state = State::Failed;
                        row.why = Some(error.to_string());
                    }
                }
                if row.state != State::Done {
                    unfinished.push(row);
                }
            }
        }
        if runs.is_empty() && unfinished.is_empty() && !left_out.is_empty() {
            return Err(left_out.swap_remove(0).into());
        }
        for error in left_out {
            printer.note(format_args!("note: {error}; it is left out"));
        }
        let Groups { groups, repeated } = Groups::of(runs);
        for Repeated { folder, counted } in repeated {
            let (folder, counted) = (folder.display(), counted.display());
            printer.note(format_args!(
                "note: `{folder}` has the settings and the seed of `{counted}` and is left out"
            ));
        }
        Ok(Self { groups, unfinished })
    }
}

/// What the table of cells that are not done is called.
pub(crate) const UNFINISHED: &str = "Cells that are not done, counted as far as they are";

/// The cells that are not at their end; `None` if all are.
pub(crate) fn unfinished(rows: &[Row]) -> Option<Table> {
    let mut listing = table();
    listing.set_header(["cell", "task", "seed", "group", "state", "steps", "why"]);
    for row in rows {
        listing.add_row([
            row.cell.to_string(),
            row.task.clone(),
            row.seed.to_string(),
            row.group.clone(),
            row.state.name().to_owned(),
            thousands(row.env_steps),
            row.why.clone().unwrap_or_default(),
        ]);
    }
    (!rows.is_empty()).then_some(listing)
}
