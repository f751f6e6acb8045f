//! Tables of runs: what each came to, and what made it.

use super::page::RUNNING;
use crate::numbers::{duration, percent, thousands};
use crate::shipped;
use comfy_table::Table;
use rher_runs::{Group, Machine, Run, is_in_use, list};

/// The last evaluation of each run, and whether it can change.
pub(super) fn runs(groups: &[(Group, Vec<Run>)]) -> Table {
    let mut listing = Table::new();
    listing.set_header([
        "folder",
        "task",
        "method",
        "preset",
        "seed",
        "evaluations",
        "steps",
        "wall clock",
        "success",
        "state",
    ]);
    for run in groups.iter().flat_map(|(_, runs)| runs) {
        let Group { task, method, preset } = &run.group;
        let last = run.last();
        listing.add_row([
            shipped::name(&run.folder),
            task.clone(),
            method.clone(),
            preset.clone(),
            run.seed.to_string(),
            run.evaluations.len().to_string(),
            thousands(last.env_steps),
            duration(last.wall_s),
            percent(last.success_final),
            state(run).to_owned(),
        ]);
    }
    listing
}

/// In a word, as `rher runs` says it.
fn state(run: &Run) -> &'static str {
    if is_in_use(&run.folder) {
        return RUNNING;
    }
    let listed = list(&run.folder).ok().and_then(|mut runs| runs.pop());
    listed.and_then(Result::ok).map_or("unknown", |run| run.state.name())
}

/// What made each of the runs, as far as that was kept, and what made this page.
pub(super) fn machines(groups: &[(Group, Vec<Run>)]) -> Table {
    let mut machines = Table::new();
    machines.set_header(["what", "program", "system", "processor", "cores"]);
    let folders = groups.iter().flat_map(|(_, runs)| runs).map(|run| &run.folder);
    let runs = folders.map(|path| (shipped::name(path), Machine::of_run(path)));
    for (what, machine) in runs.chain([("this page".to_owned(), Ok(Some(Machine::here())))]) {
        let row = match machine {
            Ok(Some(Machine { program, system, processor, cores })) => {
                [program, system, processor, cores.to_string()]
            }
            Ok(None) => ["not kept", "", "", ""].map(str::to_owned),
            Err(_) => ["its `machine.toml` is damaged", "", "", ""].map(str::to_owned),
        };
        machines.add_row([what].into_iter().chain(row));
    }
    machines
}
