//! Settings as a TOML file.

use super::describe::{self, Described, section_doc, wrap};
use super::{Settings, SettingsError};
use rher_core::config::{Setting, SettingVisitor, StartedFrom, TrainConfig, Value as SettingValue};
use rher_envs::{Options, Randomize, TaskOptions};
use serde::{Deserialize, Serialize};
use toml::ser::{Error, ValueSerializer};
use toml::{Table, Value};

/// Section about the run that another one started from, in the files of runs that did.
pub(super) const FROM: &str = "from";

/// Which comments a settings file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comments {
    /// One sentence about each setting.
    Short,
    /// Everything about each setting: explanation, range and values.
    Full,
}

/// The settings as a file that `--config` takes.
pub fn to_toml(settings: &Settings) -> Result<String, SettingsError> {
    write(settings, None)
}

/// The same, with comments.
pub fn to_toml_with(settings: &Settings, comments: Comments) -> Result<String, SettingsError> {
    write(settings, Some(comments))
}

fn write(settings: &Settings, comments: Option<Comments>) -> Result<String, SettingsError> {
    let mut text = Vec::new();
    let mut section = String::new();
    for (key, value) in lines(settings)? {
        let (of, name) = key.split_once('.').unwrap_or(("", &key));
        if of != section {
            of.clone_into(&mut section);
            text.push(String::new());
            if comments.is_some() {
                text.extend(comment(&section_doc(of)));
            }
            text.push(format!("[{of}]"));
        }
        match (comments, describe::described(&key)) {
            (Some(Comments::Short), Some(described)) => text.extend(comment(described.summary())),
            (Some(Comments::Full), Some(described)) => text.extend(full_comment(&described)),
            (None, _) | (_, None) => {}
        }
        text.push(format!("{name} = {value}"));
    }
    text.push(String::new());
    Ok(text.join("\n"))
}

/// Lines of a comment.
fn comment(text: &str) -> Vec<String> {
    wrap(text, 98).iter().map(|line| format!("# {line}")).collect()
}

/// Lines of a comment with everything about a setting.
fn full_comment(described: &Described) -> Vec<String> {
    let mut text = vec![String::new()];
    text.extend(comment(&described.doc));
    for choice in described.choices {
        text.extend(comment(&format!("- `{}`: {}", choice.name, describe::join(choice.doc))));
    }
    if described.choices.is_empty() {
        text.extend(comment(&format!("Values: {}.", described.expected)));
    }
    text
}

/// Dotted keys and values, in the order of a file.
pub(super) fn lines(settings: &Settings) -> Result<Vec<(String, String)>, Error> {
    let Settings { config, options } = settings;
    let mut values = Values(Vec::new());
    config.visit(&mut values)?;
    let Values(values) = values;
    let (sections, top): (Vec<_>, Vec<_>) =
        values.into_iter().partition(|(key, _)| key.contains('.'));
    let (task, mut lines): (Vec<_>, Vec<_>) = top.into_iter().partition(|(key, _)| key == "task");
    if let Some(StartedFrom { task, run, updates }) = &config.from {
        let facts =
            [("task", written(task)?), ("run", written(run)?), ("updates", written(updates)?)];
        lines.extend(facts.map(|(name, value)| (format!("{FROM}.{name}"), value)));
    }
    lines.extend(task.into_iter().map(|(_, name)| (describe::NAME.to_owned(), name)));
    for (name, value) in &options.task.0 {
        lines.push((format!("task.{name}"), written(value)?));
    }
    // Its values are pairs of numbers, so every setting is one line.
    let randomize = toml::to_string(&options.randomize)?;
    let pairs = randomize.lines().filter_map(|line| line.split_once(" = "));
    lines.extend(pairs.map(|(name, pair)| (format!("randomize.{name}"), pair.to_owned())));
    lines.extend(sections);
    Ok(lines)
}

/// Collects settings with their values as TOML.
struct Values(Vec<(String, String)>);

impl SettingVisitor for Values {
    type Error = Error;

    fn visit<T: SettingValue>(
        &mut self,
        setting: &'static Setting,
        value: &T,
    ) -> Result<(), Error> {
        self.0.push((setting.key.to_owned(), written(value)?));
        Ok(())
    }
}

fn written(value: &impl Serialize) -> Result<String, Error> {
    let mut text = String::new();
    value.serialize(ValueSerializer::new(&mut text))?;
    Ok(text)
}

/// The settings in the table of a file that [`to_toml`] made.
///
/// # Errors
///
/// If a setting is missing, unknown, or of another type.
pub fn from_table(table: Table) -> Result<Settings, toml::de::Error> {
    split(table)
}

/// The table of a file.
pub(super) fn table(Settings { config, options }: &Settings) -> Result<Table, Error> {
    let mut table = Table::try_from(config)?;
    let mut task = Table::try_from(&options.task)?;
    if let Some(name) = table.remove("task") {
        task.insert("name".to_owned(), name);
    }
    table.insert("task".to_owned(), Value::Table(task));
    table.insert("randomize".to_owned(), Value::try_from(&options.randomize)?);
    Ok(table)
}

/// Takes a file's table apart.
pub(super) fn split(mut table: Table) -> Result<Settings, toml::de::Error> {
    let mut take = |key: &str| table.remove(key).unwrap_or_else(|| Value::Table(Table::new()));
    let randomize = Randomize::deserialize(take("randomize"))?;
    let mut task = take("task");
    let name = task.as_table_mut().and_then(|task| task.remove("name"));
    // Settings from before there were options have the name alone.
    let name = name.unwrap_or_else(|| std::mem::replace(&mut task, Value::Table(Table::new())));
    table.insert("task".to_owned(), name);
    let config = TrainConfig::deserialize(table)?;
    Ok(Settings { config, options: Options { task: TaskOptions::deserialize(task)?, randomize } })
}
