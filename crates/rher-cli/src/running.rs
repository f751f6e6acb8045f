//! What is said of a run that is read while a process trains it.

use crate::numbers::thousands;
use crate::printer::Printer;
use rher_runs::{is_in_use, read_evaluations};
use std::path::Path;

/// Says that a policy, of a run folder or in a file in one, is not the last one of its run, where a
/// process still trains it.
pub(crate) fn note_policy(path: &Path, printer: Printer) {
    // What is neither may be the name of a task, whose policy ships with the program.
    if path.is_dir() {
        note(path, "its policy of step", printer);
    } else if let (true, Some(folder)) = (path.is_file(), path.parent()) {
        note(folder, "its policy of step", printer);
    }
}

/// Says that the evaluations of a run are not all of them, where a process still trains it.
pub(crate) fn note_evaluations(folder: &Path, printer: Printer) {
    note(folder, "what it did until step", printer);
}

fn note(folder: &Path, what: &str, printer: Printer) {
    if !is_in_use(folder) {
        return;
    }
    let last = read_evaluations(folder, None).ok().and_then(|mut all| all.pop());
    let steps = thousands(last.map_or(0, |last| last.env_steps));
    printer.note(format_args!(
        "note: `{}` is still running; this is {what} {steps}",
        folder.display()
    ));
}
