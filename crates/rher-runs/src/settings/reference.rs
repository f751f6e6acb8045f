//! The page `docs/settings.md`.

use super::describe::{Described, Part, join, parts};
use super::file::ConfigFile;
use super::{Settings, SettingsError, Source, written};
use rher_core::config::Preset;
use rher_envs::{Options, Task};
use std::collections::BTreeMap;
use std::fmt::Write as _;

const INTRODUCTION: &str = "\
# Settings

Every setting of a run, with the values that it accepts and its default in each preset.
The program writes this page from the documentation of the settings:
`RHER_RENEW_DOCS=1 cargo test --release --test runs the_page`.

A setting is changed by `--set KEY=VALUE`, or in a TOML file for `--config`.
Each of these overrides those before it: preset, recipe of the task (preset `fast` only), \
`--config`, `--set`, other options.
`rher config <TASK>` prints the settings of a run with one sentence about each, \
`rher config <TASK> --explain` with everything that stands here, \
and `rher train --set help` lists all of them.
`version`, `preset` and `task.name` cannot be changed by `--set`.
\"One object\" and \"more\" are objects of the task; `rher tasks` lists them.
";

/// The page `docs/settings.md`.
pub fn reference() -> Result<String, SettingsError> {
    let mut text = INTRODUCTION.to_owned();
    let defaults = Defaults::of_presets()?;
    for Part { name, doc, settings } in parts() {
        let title = if name.is_empty() { "Top level".to_owned() } else { format!("`[{name}]`") };
        // Writing to a string does not fail.
        let _ = write!(text, "\n## {title}\n\n{doc}\n");
        for Described { key, doc, expected, choices, tasks } in settings {
            let _ = write!(text, "\n### `{key}`\n\n{doc}\n\n");
            for choice in choices {
                let _ = writeln!(text, "- `{}`: {}", choice.name, join(choice.doc));
            }
            if choices.is_empty() {
                let _ = writeln!(text, "- Values: {expected}.");
            }
            for task in tasks {
                let options = task.options().iter();
                for option in options.filter(|option| key == format!("task.{}", option.name)) {
                    let _ =
                        writeln!(text, "- Default: `{}`; only `{task}` has it.", option.default);
                }
            }
            for default in defaults.of(&key) {
                let _ = writeln!(text, "- {default}");
            }
        }
    }
    Ok(text)
}

/// What every setting is in every preset, and in recipes.
struct Defaults {
    /// For each preset, with one object, two and three.
    presets: Vec<(Preset, [BTreeMap<String, String>; 3])>,
    recipes: Vec<(Task, ConfigFile)>,
}

impl Defaults {
    fn of_presets() -> Result<Self, SettingsError> {
        let with = |preset: Preset, objects| {
            let config = preset.config("", objects);
            written::lines(&Settings { config, options: Options::default() })
        };
        let preset = |&preset: &Preset| -> Result<_, SettingsError> {
            let [one, two, three] = [1, 2, 3].map(|objects| with(preset, objects));
            Ok((preset, [one?, two?, three?].map(BTreeMap::from_iter)))
        };
        let recipe = |&task: &Task| {
            let parse = |text: &str| ConfigFile::parse(Source::Recipe(task), text.to_owned());
            task.recipe().map(|text| Ok((task, parse(text)?)))
        };
        Ok(Self {
            presets: Preset::ALL.iter().map(preset).collect::<Result<_, _>>()?,
            recipes: Task::ALL.iter().filter_map(recipe).collect::<Result<_, SettingsError>>()?,
        })
    }

    /// Sentences about the defaults of a setting.
    fn of(&self, key: &str) -> Vec<String> {
        if matches!(key, "preset" | "task.name") {
            return Vec::new();
        }
        let mut groups: Vec<(Vec<String>, String)> = Vec::new();
        for (preset, objects) in &self.presets {
            let [Some(one), Some(two), Some(three)] =
                objects.each_ref().map(|values| values.get(key))
            else {
                continue;
            };
            let values = if one == two && two == three {
                format!("`{one}`")
            } else if two == three {
                format!("`{one}` with one object, `{two}` with more")
            } else {
                format!("`{one}` with one object, `{two}` with two, `{three}` with more")
            };
            let preset = format!("`{}`", preset.name());
            match groups.iter_mut().find(|(_, other)| *other == values) {
                Some((presets, _)) => presets.push(preset),
                None => groups.push((vec![preset], values)),
            }
        }
        let mut sentences: Vec<_> = match groups.as_slice() {
            [(_, values)] => vec![format!("Default: {values}.")],
            groups => groups
                .iter()
                .map(|(presets, values)| format!("Default of {}: {values}.", presets.join(" and ")))
                .collect(),
        };
        for (task, recipe) in &self.recipes {
            for entry in recipe.entries.iter().filter(|entry| entry.key == key) {
                sentences.push(format!("Recipe of `{task}`: `{}`.", entry.value));
            }
        }
        sentences
    }
}
