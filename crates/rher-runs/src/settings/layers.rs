//! Settings that are being put together, one layer over the other.

use super::describe::expected;
use super::error::{Origin, SettingsError, Source};
use super::file::ConfigFile;
use super::written::{FROM, split, table};
use super::{Asked, Settings};
use rher_core::config::{EngineKind, Precision};
use rher_envs::Task;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Settings that `--set` leaves alone.
const FIXED: [&str; 4] = ["version", "task", "task.name", "preset"];

/// Longest key for which a similar one is looked for, in bytes.
const LONGEST_KEY: usize = 100;

/// Settings that are being put together.
pub(super) struct Layers {
    /// None if the environment is someone else's, which has no settings here.
    task: Option<Task>,
    table: Table,
    settings: Settings,
    origins: BTreeMap<String, Origin>,
}

impl Layers {
    pub(super) fn new(task: Option<Task>, settings: Settings) -> Result<Self, SettingsError> {
        let mut table = table(&settings)?;
        if task.is_none() {
            table.remove("randomize");
        }
        Ok(Self { task, table, settings, origins: BTreeMap::new() })
    }

    /// Sets what the user asks for.
    pub(super) fn ask(
        &mut self,
        file: Option<ConfigFile>,
        asked: &Asked,
    ) -> Result<(), SettingsError> {
        let Asked {
            preset: _,
            config: _,
            set,
            method,
            seed,
            env_steps,
            until,
            engine,
            precision,
            envs,
        } = asked;
        if let Some(file) = file {
            self.set_all(&file)?;
        }
        for (key, value) in set {
            if FIXED.contains(&key.as_str()) {
                return Err(SettingsError::Fixed { key: key.clone() });
            }
            self.set(key, value, || Source::Set.into())?;
        }
        let whole = |key, option, number: &Option<u64>| {
            number.map(|number| integer(key, option, number)).transpose()
        };
        let options = [
            ("relay.method", "--method", method.map(|method| method.name().into())),
            ("seed", "--seed", whole("seed", "--seed", seed)?),
            ("env_steps", "--env-steps", whole("env_steps", "--env-steps", env_steps)?),
            ("until", "--until", until.map(|rate| Value::Float(rate.into()))),
            ("agent.engine", "--engine", engine.map(|engine| engine.name().into())),
            ("agent.precision", "--precision", precision.map(|it| it.name().into())),
            ("envs", "--envs", whole("envs", "--envs", envs)?),
        ];
        for (key, option, value) in options {
            if let Some(value) = value {
                self.set(key, &value, || Source::Option(option).into())?;
            }
        }
        if *engine == Some(EngineKind::Burn) && !self.origins.contains_key("agent.precision") {
            // The only one that this engine has.
            let precision = Precision::F32.name().into();
            self.set("agent.precision", &precision, || Source::Option("--engine").into())?;
        }
        Ok(())
    }

    /// Sets what concerns the environments.
    pub(super) fn set_options(&mut self, set: &[(String, Value)]) -> Result<(), SettingsError> {
        for (key, value) in set {
            let is_fixed = FIXED.contains(&key.as_str());
            let of_environments = ["task.", "randomize."].iter().any(|it| key.starts_with(it));
            if is_fixed || !of_environments && lookup(&mut self.table, key).is_some() {
                return Err(SettingsError::NotOfEnvironments { key: key.clone() });
            }
            self.set(key, value, || Source::Set.into())?;
        }
        Ok(())
    }

    pub(super) fn set_all(&mut self, file: &ConfigFile) -> Result<(), SettingsError> {
        let mut entries = file.entries.iter();
        entries.try_for_each(|entry| self.set(&entry.key, &entry.value, || file.origin(entry)))
    }

    /// Sets one setting; `origin` says who asked for it.
    fn set(
        &mut self,
        key: &str,
        value: &Value,
        origin: impl Fn() -> Origin,
    ) -> Result<(), SettingsError> {
        match (lookup(&mut self.table, key), value) {
            (Some(Value::Table(_)), Value::Table(empty)) if empty.is_empty() => return Ok(()),
            (Some(Value::Table(_)), _) => {
                return Err(SettingsError::Section { origin: origin(), key: key.to_owned() });
            }
            (Some(slot), value) => *slot = value.clone(),
            (None, _) => return Err(self.unknown(key, origin())),
        }
        self.settings =
            split(self.table.clone()).map_err(|_| SettingsError::mistyped(origin(), key, value))?;
        self.origins.insert(key.to_owned(), origin());
        Ok(())
    }

    fn unknown(&self, key: &str, origin: Origin) -> SettingsError {
        let of_from = key.split('.').next() == Some(FROM);
        let key = key.to_owned();
        if of_from {
            return SettingsError::StartedFrom { origin, key };
        }
        if let (Some(task), Some(owner)) = (self.task, owner(&key)) {
            return SettingsError::OtherTasksOption { origin, key, owner, task };
        }
        let nearest = nearest(&self.table, &key);
        SettingsError::Unknown { origin, key, nearest }
    }

    /// The settings, once they are in their ranges.
    pub(super) fn finish(self) -> Result<Settings, SettingsError> {
        let Settings { config, options } = self.settings;
        let known = self.task.map_or(&[][..], Task::options);
        let options = match options.check(known) {
            Ok(options) => options,
            Err(error) => {
                return Err(match self.origins.get(error.key()) {
                    Some(origin) => SettingsError::Option { origin: origin.clone(), error },
                    None => SettingsError::Unfit(error),
                });
            }
        };
        let Err(error) = config.validate() else { return Ok(Settings { config, options }) };
        match self.origins.into_iter().find(|(key, _)| error.concerns(key)) {
            Some((_, origin)) => Err(SettingsError::OutOfRange { origin, error }),
            None => Err(error.into()),
        }
    }
}

/// The value of an option as TOML has it, whose integers have a sign.
fn integer(key: &str, option: &'static str, number: u64) -> Result<Value, SettingsError> {
    i64::try_from(number).map(Value::Integer).map_err(|_| SettingsError::Mistyped {
        origin: Source::Option(option).into(),
        key: key.to_owned(),
        value: number.to_string().into(),
        expected: expected(key).unwrap_or_default().into(),
    })
}

/// A task that has an option with this dotted key.
fn owner(key: &str) -> Option<Task> {
    let name = key.strip_prefix("task.")?;
    let has_it = |task: &Task| task.options().iter().any(|option| option.name == name);
    Task::all().into_iter().find(has_it)
}

/// The value of a dotted key.
fn lookup<'a>(table: &'a mut Table, key: &str) -> Option<&'a mut Value> {
    match key.split_once('.') {
        Some((section, rest)) => lookup(table.get_mut(section)?.as_table_mut()?, rest),
        None => table.get_mut(key),
    }
}

/// The known key that is most similar to `key`, if any is.
fn nearest(table: &Table, key: &str) -> Option<String> {
    const SIMILAR: f64 = 0.8;
    if key.len() > LONGEST_KEY {
        return None;
    }
    let last = |key: &str| key.rsplit('.').next().map(str::to_owned).unwrap_or_default();
    let similarity = |known: &str| {
        strsim::jaro_winkler(known, key).max(strsim::jaro_winkler(&last(known), &last(key)))
    };
    known_keys(table)
        .into_iter()
        .map(|known| (similarity(&known), known))
        .filter(|(similarity, _)| *similarity > SIMILAR)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, known)| known)
}

/// Settings and sections, dotted.
fn known_keys(table: &Table) -> Vec<String> {
    table
        .iter()
        .flat_map(|(name, value)| match value {
            Value::Table(section) => {
                let keys = known_keys(section).into_iter().map(|key| format!("{name}.{key}"));
                std::iter::once(name.clone()).chain(keys).collect()
            }
            _ => vec![name.clone()],
        })
        .collect()
}
