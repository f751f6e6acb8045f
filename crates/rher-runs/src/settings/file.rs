//! A settings file: what it sets, and where.

use super::describe::{NAME, expected};
use super::error::{Origin, Place, SettingsError, Source};
use rher_core::config::{Preset, VERSION};
use serde::Deserialize;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;
use toml::Value;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// Largest settings file in bytes; those of `rher config --explain` have about 20 kB.
pub const LARGEST_FILE: u64 = 1 << 20;

/// Deepest section of a settings file; whatever is below it is unknown.
const DEEPEST: usize = 3;

/// The text of a settings file of at most [`LARGEST_FILE`] bytes.
///
/// # Errors
///
/// Those of the file system, and [`io::ErrorKind::FileTooLarge`].
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(LARGEST_FILE + 1).read_to_string(&mut text)?;
    if text.len() as u64 > LARGEST_FILE {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("a settings file has at most {LARGEST_FILE} bytes"),
        ));
    }
    Ok(text)
}

/// A settings file, flattened.
pub(super) struct ConfigFile {
    source: Source,
    text: String,
    pub(super) entries: Vec<Entry>,
}

/// One setting of a file.
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) value: Value,
    /// Where its key begins, in bytes.
    offset: usize,
}

impl ConfigFile {
    pub(super) fn read(path: &Path) -> Result<Self, SettingsError> {
        let text = read_text(path)
            .map_err(|source| SettingsError::Read { path: path.to_owned(), source })?;
        Self::parse(Source::File(path.to_owned()), text)
    }

    pub(super) fn parse(source: Source, text: String) -> Result<Self, SettingsError> {
        let mut file = Self { source, text, entries: Vec::new() };
        let table = DeTable::parse(&file.text).map_err(|error| SettingsError::Syntax {
            origin: file.origin_at(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        })?;
        let mut entries = Vec::new();
        file.flatten("", 1, table.into_inner(), &mut entries)?;
        // `task = "push"` is short for the name in `[task]`.
        for entry in &mut entries {
            if entry.key == "task" {
                NAME.clone_into(&mut entry.key);
            }
        }
        // The parser sorts by key; the first mistake in the file should be reported first.
        entries.sort_by_key(|entry| entry.offset);
        file.entries = entries;
        file.check_version()?;
        Ok(file)
    }

    /// Lists the leaves of `table` with their dotted keys.
    fn flatten(
        &self,
        prefix: &str,
        depth: usize,
        table: DeTable<'_>,
        entries: &mut Vec<Entry>,
    ) -> Result<(), SettingsError> {
        for (name, value) in table {
            let offset = name.span().start;
            let key = format!("{prefix}{}", name.into_inner());
            let span = value.span();
            let value = match value.into_inner() {
                DeValue::Table(table) if !table.is_empty() && depth < DEEPEST => {
                    self.flatten(&format!("{key}."), depth + 1, table, entries)?;
                    continue;
                }
                DeValue::Table(_) => Value::Table(toml::Table::new()),
                leaf => {
                    let is_integer = matches!(leaf, DeValue::Integer(_));
                    let leaf = ValueDeserializer::from(toml::Spanned::new(span.clone(), leaf));
                    Value::deserialize(leaf).map_err(|error| {
                        let origin = self.origin_at(offset);
                        match expected(&key) {
                            Some(expected) if is_integer => SettingsError::Mistyped {
                                origin,
                                key: key.clone(),
                                value: self.text[span].into(),
                                expected: expected.into(),
                            },
                            _ => SettingsError::Syntax {
                                origin,
                                problem: error.message().to_owned(),
                            },
                        }
                    })?
                }
            };
            entries.push(Entry { key, value, offset });
        }
        Ok(())
    }

    /// Where `entry` was made.
    pub(super) fn origin(&self, entry: &Entry) -> Origin {
        self.origin_at(entry.offset)
    }

    fn origin_at(&self, offset: usize) -> Origin {
        Origin { source: self.source.clone(), at: Some(Place::of(&self.text, offset)) }
    }

    fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    fn check_version(&self) -> Result<(), SettingsError> {
        match self.entry("version") {
            Some(entry @ Entry { value: Value::Integer(found), .. })
                if *found != i64::from(VERSION) =>
            {
                Err(SettingsError::Version { origin: self.origin(entry), found: *found })
            }
            _ => Ok(()),
        }
    }

    pub(super) fn check_task(&self, task: &str) -> Result<(), SettingsError> {
        match self.entry(NAME) {
            Some(entry @ Entry { value: Value::String(found), .. }) if found != task => {
                let (origin, found, task) = (self.origin(entry), found.clone(), task.to_owned());
                Err(SettingsError::OtherTask { origin, found, task })
            }
            _ => Ok(()),
        }
    }

    /// The preset that the file starts from, which must be the one `asked` for.
    pub(super) fn preset(&self, asked: Option<Preset>) -> Result<Preset, SettingsError> {
        let Some(entry) = self.entry("preset") else { return Ok(asked.unwrap_or(Preset::Fast)) };
        let origin = self.origin(entry);
        match (Preset::deserialize(entry.value.clone()), asked) {
            (Err(_), _) => Err(SettingsError::mistyped(origin, &entry.key, &entry.value)),
            (Ok(preset), Some(asked)) if asked != preset => {
                Err(SettingsError::OtherPreset { origin })
            }
            (Ok(preset), _) => Ok(preset),
        }
    }
}
