//! Whether a run that is there is the run that is asked for.

use crate::settings::{self, Settings, SettingsError};
use crate::{Asked, ConfigFile, Run};
use rher_core::config::Preset;
use rher_envs::Task;
use std::path::PathBuf;
use toml::{Table, Value};

/// A run has other settings than those that it is asked for with.
#[derive(Debug, thiserror::Error)]
#[error("the run in `{}` has `{key}` = {found}, but {asked} is asked for", folder.display())]
pub struct OtherSettings {
    /// Folder of the run.
    pub folder: PathBuf,
    /// Dotted.
    pub key: String,
    /// Value in the run.
    pub found: String,
    /// Value that is asked for.
    pub asked: String,
}

/// The first setting, in the order of their keys, whose value in `found` is not the one in `asked`:
/// its key and both values. `env_steps` and `until`, which only say when a run ends, may differ.
///
/// # Errors
///
/// If one of them cannot be written as TOML.
pub fn difference(
    found: &Settings,
    asked: &Settings,
) -> Result<Option<(String, String, String)>, SettingsError> {
    let [found, asked] = [flat(found)?, flat(asked)?];
    let value = |list: &[(String, String)], key: &str| {
        let entry = list.iter().find(|(known, _)| known == key);
        entry.map_or_else(|| "nothing".to_owned(), |(_, value)| value.clone())
    };
    let mut keys: Vec<&String> = found.iter().chain(&asked).map(|(key, _)| key).collect();
    keys.sort();
    let differs = keys.into_iter().find(|key| value(&found, key) != value(&asked, key));
    Ok(differs.map(|key| (key.clone(), value(&found, key), value(&asked, key))))
}

/// A setting of a run that is not the one of its preset; a side that does not know it is `None`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Departure {
    /// Dotted.
    pub key: String,
    /// Value in the preset, as TOML.
    pub preset: Option<String>,
    /// Value in the run, as TOML.
    pub run: Option<String>,
}

/// What settings of a run are not those that its preset has for its task today, in the order of their
/// keys, but the seed; `None` if the task or the preset is not known here.
pub fn departures(run: &Run) -> Option<Vec<Departure>> {
    let task: Task = run.group.task.parse().ok()?;
    let name = run.settings.get("preset")?.as_str()?;
    let preset = Preset::ALL.iter().copied().find(|preset| preset.name() == name)?;
    let asked = Asked { preset: Some(preset), ..Asked::default() };
    let mut expected = every(&settings::resolve(task, &asked).ok()?).ok()?;
    let mut found = Vec::new();
    let mut table = ConfigFile::read(&run.folder).ok()??.into_table();
    if let Some(name @ Value::String(_)) = table.get("task").cloned() {
        // Earlier versions wrote its name alone.
        table
            .insert("task".to_owned(), Value::Table(Table::from_iter([("name".to_owned(), name)])));
    }
    flatten("", table, &mut found);
    expected.retain(|(key, _)| key != "seed");
    found.retain(|(key, _)| key != "seed");
    let value = |list: &[(String, String)], key: &str| {
        list.iter().find(|(known, _)| known == key).map(|(_, value)| value.clone())
    };
    let mut keys: Vec<&String> = expected.iter().chain(&found).map(|(key, _)| key).collect();
    keys.sort();
    keys.dedup();
    let departure = |key: &String| {
        let (preset, run) = (value(&expected, key), value(&found, key));
        (preset != run).then(|| Departure { key: key.clone(), preset, run })
    };
    Some(keys.into_iter().filter_map(departure).collect())
}

/// Every setting but those of the end, with its dotted key and its value as TOML.
fn flat(settings: &Settings) -> Result<Vec<(String, String)>, SettingsError> {
    let mut entries = every(settings)?;
    entries.retain(|(key, _)| key != "env_steps" && key != "until");
    Ok(entries)
}

/// Every setting, with its dotted key and its value as TOML.
fn every(settings: &Settings) -> Result<Vec<(String, String)>, SettingsError> {
    let text = settings::to_toml(settings)?;
    let table: Table = text.parse().expect("TOML that was just written can be read");
    let mut entries = Vec::new();
    flatten("", table, &mut entries);
    Ok(entries)
}

fn flatten(prefix: &str, table: Table, entries: &mut Vec<(String, String)>) {
    for (name, value) in table {
        let key = format!("{prefix}{name}");
        match value {
            Value::Table(table) => flatten(&format!("{key}."), table, entries),
            value => entries.push((key, value.to_string())),
        }
    }
}
