//! The settings of each group: what is not as in its preset, and everything on demand.

use super::page::Page;
use crate::shipped;
use comfy_table::Table;
use rher_core::files::FileError;
use rher_runs::{CONFIG_FILE, Departure, Group, Run, departures};

/// Adds the settings of a group, which are those of its first run.
pub(super) fn add(page: &mut Page, group: &Group, runs: &[Run]) -> anyhow::Result<()> {
    let run = &runs[0];
    page.part(&group.to_string());
    if runs.iter().any(|other| other.settings != run.settings) {
        page.paragraph(&format!(
            "The runs of this group differ in more than the seed; these are the settings of {}.",
            shipped::name(&run.folder)
        ));
    }
    match departures(run) {
        None => page.paragraph("This program does not know the task or the preset of these runs."),
        Some(departures) if departures.is_empty() => {
            page.paragraph(&format!("Every setting is that of the preset. {TRAIN}"));
            page.code(&command(run, &departures));
        }
        Some(departures) => {
            page.table(
                &format!("What is not as in the preset {}", preset(run)),
                &table(&departures),
            );
            if is_known(&departures) {
                page.paragraph(TRAIN);
                page.code(&command(run, &departures));
            }
        }
    }
    let path = run.folder.join(CONFIG_FILE);
    let text = std::fs::read_to_string(&path).map_err(FileError::read(&path))?;
    page.details(&format!("All settings, as in {}", shipped::name(&path)), &text);
    Ok(())
}

const TRAIN: &str = "This command trains with the same settings:";

fn table(departures: &[Departure]) -> Table {
    let mut table = Table::new();
    table.set_header(["setting", "preset", "these runs"]);
    for Departure { key, preset, run } in departures {
        let preset = preset.as_deref().unwrap_or("no longer a setting");
        table.add_row([key, preset, run.as_deref().unwrap_or("not a setting then")]);
    }
    table
}

/// Whether every setting exists on both sides, as in runs of this version that started from nothing.
fn is_known(departures: &[Departure]) -> bool {
    departures.iter().all(|departure| departure.preset.is_some() && departure.run.is_some())
}

fn preset(run: &Run) -> &str {
    run.settings.get("preset").and_then(|preset| preset.as_str()).unwrap_or_default()
}

/// What trains the same run; none where this program does not know all of its settings.
pub(crate) fn train_command(run: &Run) -> Option<String> {
    let departures = departures(run).filter(|departures| is_known(departures))?;
    Some(command(run, &departures))
}

/// What trains a run with the same settings.
fn command(run: &Run, departures: &[Departure]) -> String {
    let task = &run.group.task;
    let mut words = vec!["rher", "train", task, "--preset", preset(run), "--seed"]
        .into_iter()
        .map(str::to_owned)
        .collect::<Vec<_>>();
    words.push(run.seed.to_string());
    for Departure { key, run, .. } in departures {
        words.push("--set".to_owned());
        words.push(format!("{key}={}", run.as_deref().unwrap_or_default()));
    }
    super::facts::shell(words)
}
