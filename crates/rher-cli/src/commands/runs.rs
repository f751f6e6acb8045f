//! `rher runs`: what is there.

use crate::cli::{DEFAULT_FOLDER, ListArgs};
use crate::numbers::{bytes, percent, thousands};
use crate::printer::Printer;
use crate::tables::{table, text};
use rher_runs::{Listed, list};
use std::path::Path;

pub(crate) fn runs(args: &ListArgs, printer: Printer) -> anyhow::Result<()> {
    let mut runs = Vec::new();
    // Whoever has not trained yet has no such folder.
    let is_unmade = args.folder == Path::new(DEFAULT_FOLDER) && !args.folder.exists();
    for run in if is_unmade { Vec::new() } else { list(&args.folder)? } {
        match run {
            Ok(run) => runs.push(run),
            Err(error) => printer.warn(format_args!("{:#}", anyhow::Error::from(error))),
        }
    }
    if args.json {
        printer.data(&serde_json::to_string_pretty(&runs)?)?;
        return Ok(());
    }
    if runs.is_empty() {
        printer.note(format_args!(
            "there is no run in `{}`; `rher train push` makes one",
            args.folder.display()
        ));
        return Ok(());
    }
    let mut listing = table();
    listing.set_header(["run", "task", "preset", "seed", "steps", "success", "state", "disk"]);
    for Listed { folder, group, seed, env_steps, success_final, state, bytes: size } in runs {
        let preset = match group.method.as_str() {
            "rher" => group.preset,
            method => format!("{method} {}", group.preset),
        };
        listing.add_row([
            folder.display().to_string(),
            group.task,
            preset,
            seed.to_string(),
            thousands(env_steps),
            success_final.map_or("–".to_owned(), percent),
            state.name().to_owned(),
            bytes(size),
        ]);
    }
    printer.data(&text(&listing))?;
    Ok(())
}
