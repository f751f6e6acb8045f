//! Settings of a run: preset < recipe of the task < `--config` < `--set` < other options.

use crate::cli::{Assignment, SettingsArgs};
use rher_core::agent::config::AgentConfig;
use rher_core::config::{
    ConfigError, EvaluationConfig, ExplorationConfig, Method, Preset, RelayConfig, ReplayConfig,
    TrainConfig, VERSION,
};
use rher_envs::{EnvVisitor, OptionError, Options, Randomize, Simulated, Task, TaskOptions};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue, ValueDeserializer};
use toml::{Table, Value};

/// Settings that `--set` leaves alone.
const FIXED: [&str; 4] = ["version", "task", "task.name", "preset"];

/// Everything that is part of an experiment: how it is learned, and in which environments.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Settings {
    pub(crate) config: TrainConfig,
    pub(crate) options: Options,
}

/// The settings that `args` and the files they name come to.
pub(crate) fn resolve(task: Task, args: &SettingsArgs) -> Result<Settings, SettingsError> {
    let SettingsArgs { preset, config, set, method, seed, env_steps, until, engine, envs } = args;
    let file = config.as_deref().map(ConfigFile::read).transpose()?;
    if let Some(file) = &file {
        file.check_task(task)?;
    }
    let asked = preset.map(Preset::from);
    let preset = match &file {
        Some(file) => file.preset(asked)?,
        None => asked.unwrap_or(Preset::Fast),
    };
    let config = preset.config(task.name(), task.visit(Objects));
    let mut layers = Layers::new(task, Settings { config, options: Options::of(task.options()) })?;
    if let (Preset::Fast, Some(recipe)) = (preset, recipe(task)) {
        layers.set_all(ConfigFile::parse(&Source::Recipe(task), recipe)?.entries)?;
    }
    if let Some(file) = file {
        layers.set_all(file.entries)?;
    }
    for Assignment { key, value } in set {
        if FIXED.contains(&key.as_str()) {
            return Err(SettingsError::Fixed { key: key.clone() });
        }
        layers.set(Entry::new(key, value.clone(), Source::Set))?;
    }
    let options = [
        ("relay.method", "--method", method.map(|name| Method::from(name).name().into())),
        ("seed", "--seed", seed.map(|seed| Value::Integer(seed.cast_signed()))),
        ("env_steps", "--env-steps", env_steps.map(|steps| Value::Integer(steps.cast_signed()))),
        ("until", "--until", until.map(|rate| Value::Float(rate.into()))),
        ("agent.engine", "--engine", engine.map(|engine| engine.name().into())),
        ("envs", "--envs", envs.map(|envs| Value::Integer(envs.cast_signed()))),
    ];
    for (key, option, value) in options {
        if let Some(value) = value {
            layers.set(Entry::new(key, value, Source::Option(option)))?;
        }
    }
    layers.finish()
}

/// Settings that reach the success rate on a task sooner, or with a better budget, than the
/// preset alone.
fn recipe(task: Task) -> Option<&'static str> {
    match task {
        Task::Reach => Some(include_str!("../../../recipes/reach.toml")),
        Task::CuePush => Some(include_str!("../../../recipes/cue-push.toml")),
        _ => None,
    }
}

/// Finds how many objects a task has.
struct Objects;

impl EnvVisitor for Objects {
    type Output = usize;

    fn visit<const N: usize, E: Simulated<N>>(self, _build: impl Fn() -> E + Sync) -> usize {
        N
    }
}

/// A settings file, flattened.
struct ConfigFile {
    entries: Vec<Entry>,
}

impl ConfigFile {
    fn read(path: &Path) -> Result<Self, SettingsError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SettingsError::Read { path: path.to_owned(), source })?;
        Self::parse(&Source::File(path.to_owned()), &text)
    }

    fn parse(source: &Source, text: &str) -> Result<Self, SettingsError> {
        let at =
            |offset: usize| Origin { source: source.clone(), at: Some(Place::of(text, offset)) };
        let table = DeTable::parse(text).map_err(|error| SettingsError::Syntax {
            origin: at(error.span().map_or(0, |span| span.start)),
            problem: error.message().to_owned(),
        })?;
        let mut entries = Vec::new();
        flatten("", table.into_inner(), &at, &mut entries)?;
        // `task = "push"` is short for the name in `[task]`.
        for entry in &mut entries {
            if entry.key == "task" {
                NAME.clone_into(&mut entry.key);
            }
        }
        // The parser sorts by key; the first mistake in the file should be the first one told.
        entries.sort_by_key(|entry| entry.origin.at);
        let file = Self { entries };
        file.check_version()?;
        Ok(file)
    }

    fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    fn check_version(&self) -> Result<(), SettingsError> {
        match self.entry("version") {
            Some(Entry { value: Value::Integer(found), origin, .. })
                if *found != i64::from(VERSION) =>
            {
                Err(SettingsError::Version { origin: origin.clone(), found: *found })
            }
            _ => Ok(()),
        }
    }

    fn check_task(&self, task: Task) -> Result<(), SettingsError> {
        match self.entry(NAME) {
            Some(Entry { value: Value::String(found), origin, .. }) if found != task.name() => {
                Err(SettingsError::OtherTask { origin: origin.clone(), found: found.clone(), task })
            }
            _ => Ok(()),
        }
    }

    /// The preset that the file starts from, which must be the one `asked` for.
    fn preset(&self, asked: Option<Preset>) -> Result<Preset, SettingsError> {
        let Some(entry) = self.entry("preset") else { return Ok(asked.unwrap_or(Preset::Fast)) };
        let preset =
            Preset::deserialize(entry.value.clone()).map_err(|error| entry.mistyped(&error))?;
        match asked {
            Some(asked) if asked != preset => {
                Err(SettingsError::OtherPreset { origin: entry.origin.clone() })
            }
            _ => Ok(preset),
        }
    }
}

/// Lists the leaves of `table` with their dotted keys.
fn flatten(
    prefix: &str,
    table: DeTable<'_>,
    at: &impl Fn(usize) -> Origin,
    entries: &mut Vec<Entry>,
) -> Result<(), SettingsError> {
    for (name, value) in table {
        let origin = at(name.span().start);
        let key = format!("{prefix}{}", name.into_inner());
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) if !table.is_empty() => {
                flatten(&format!("{key}."), table, at, entries)?;
            }
            leaf => {
                let spanned = toml::Spanned::new(span, leaf);
                let value =
                    Value::deserialize(ValueDeserializer::from(spanned)).map_err(|error| {
                        SettingsError::Syntax {
                            origin: origin.clone(),
                            problem: error.message().to_owned(),
                        }
                    })?;
                entries.push(Entry { key, value, origin });
            }
        }
    }
    Ok(())
}

/// One setting, and where it was made.
struct Entry {
    key: String,
    value: Value,
    origin: Origin,
}

impl Entry {
    fn new(key: &str, value: Value, source: Source) -> Self {
        Self { key: key.to_owned(), value, origin: Origin { source, at: None } }
    }

    fn mistyped(&self, error: &toml::de::Error) -> SettingsError {
        SettingsError::Mistyped {
            origin: self.origin.clone(),
            key: self.key.clone(),
            problem: in_plain_words(error.message()),
        }
    }
}

/// What serde says, without the names of Rust's types.
fn in_plain_words(problem: &str) -> String {
    const WORDS: [(&str, &str); 8] = [
        ("unknown variant", "unknown value"),
        ("expected f32", "expected a number"),
        ("expected usize", "expected a whole number, at least 0"),
        ("expected u32", "expected a whole number, at least 0"),
        ("expected u64", "expected a whole number, at least 0"),
        ("expected a sequence", "expected a list in brackets"),
        ("expected a boolean", "expected true or false"),
        ("expected an array of length 2", "expected two numbers in brackets"),
    ];
    WORDS.iter().fold(problem.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// Settings that are being put together.
struct Layers {
    task: Task,
    table: Table,
    settings: Settings,
    origins: BTreeMap<String, Origin>,
}

impl Layers {
    fn new(task: Task, settings: Settings) -> Result<Self, SettingsError> {
        let table = Table::try_from(SettingsFile::of(&settings))?;
        Ok(Self { task, table, settings, origins: BTreeMap::new() })
    }

    fn set_all(&mut self, entries: Vec<Entry>) -> Result<(), SettingsError> {
        entries.into_iter().try_for_each(|entry| self.set(entry))
    }

    fn set(&mut self, entry: Entry) -> Result<(), SettingsError> {
        match (lookup(&mut self.table, &entry.key), &entry.value) {
            (Some(Value::Table(_)), Value::Table(empty)) if empty.is_empty() => return Ok(()),
            (Some(Value::Table(_)), _) => {
                return Err(SettingsError::Section { origin: entry.origin, key: entry.key });
            }
            (Some(slot), value) => *slot = value.clone(),
            (None, _) => {
                if let Some(owner) = owner(&entry.key) {
                    let (origin, key, task) = (entry.origin, entry.key, self.task);
                    return Err(SettingsError::OtherTasksOption { origin, key, owner, task });
                }
                let nearest = nearest(&self.table, &entry.key);
                return Err(SettingsError::Unknown {
                    origin: entry.origin,
                    key: entry.key,
                    nearest,
                });
            }
        }
        self.settings = split(self.table.clone()).map_err(|error| entry.mistyped(&error))?;
        self.origins.insert(entry.key, entry.origin);
        Ok(())
    }

    fn finish(self) -> Result<Settings, SettingsError> {
        let Settings { config, options } = self.settings;
        let options = match options.check(self.task.options()) {
            Ok(options) => options,
            Err(error) => {
                return Err(match self.origins.get(error.key()) {
                    Some(origin) => SettingsError::Option { origin: origin.clone(), error },
                    None => SettingsError::Unfit(error),
                });
            }
        };
        let Err(error) = config.validate() else { return Ok(Settings { config, options }) };
        // Some ranges depend on another setting, and then that one may be the culprit.
        let blamed = |key: &str| key == error.key || error.allowed.contains(&format!("`{key}`"));
        match self.origins.into_iter().find(|(key, _)| blamed(key)) {
            Some((_, origin)) => Err(SettingsError::OutOfRange { origin, error }),
            None => Err(error.into()),
        }
    }
}

/// Key of the task's name.
const NAME: &str = "task.name";

/// A task that has an option with this dotted key.
fn owner(key: &str) -> Option<Task> {
    let name = key.strip_prefix("task.")?;
    let has_it = |task: &&Task| task.options().iter().any(|option| option.name == name);
    Task::ALL.iter().find(has_it).copied()
}

/// Takes a file's table apart.
fn split(mut table: Table) -> Result<Settings, toml::de::Error> {
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

/// The value of a dotted key.
fn lookup<'a>(table: &'a mut Table, key: &str) -> Option<&'a mut Value> {
    match key.split_once('.') {
        Some((section, rest)) => lookup(table.get_mut(section)?.as_table_mut()?, rest),
        None => table.get_mut(key),
    }
}

/// The known key that looks most like `key`, if any does.
fn nearest(table: &Table, key: &str) -> Option<String> {
    const ALIKE: f64 = 0.8;
    let last = |key: &str| key.rsplit('.').next().map(str::to_owned).unwrap_or_default();
    let likeness = |known: &str| {
        strsim::jaro_winkler(known, key).max(strsim::jaro_winkler(&last(known), &last(key)))
    };
    known_keys(table)
        .into_iter()
        .map(|known| (likeness(&known), known))
        .filter(|(likeness, _)| *likeness > ALIKE)
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

/// The settings as a file that `--config` takes.
pub(crate) fn to_toml(settings: &Settings) -> Result<String, SettingsError> {
    Ok(toml::to_string(&SettingsFile::of(settings))?)
}

/// The settings in a file that [`to_toml`] made, if they can be read.
pub(crate) fn from_toml(text: &str) -> Option<Settings> {
    split(text.parse().ok()?).ok()
}

/// The sections of a settings file.
#[derive(Serialize)]
struct SettingsFile<'a> {
    version: u32,
    preset: Preset,
    seed: u64,
    env_steps: u64,
    until: f32,
    envs: usize,
    task: TaskSection<'a>,
    randomize: &'a Randomize,
    relay: &'a RelayConfig,
    exploration: &'a ExplorationConfig,
    replay: &'a ReplayConfig,
    agent: &'a AgentConfig,
    evaluation: &'a EvaluationConfig,
}

/// The task, and what is set about it.
#[derive(Serialize)]
struct TaskSection<'a> {
    name: &'a str,
    #[serde(flatten)]
    options: &'a TaskOptions,
}

impl<'a> SettingsFile<'a> {
    fn of(
        Settings { config, options: Options { task: options, randomize } }: &'a Settings,
    ) -> Self {
        let TrainConfig {
            version,
            task,
            preset,
            seed,
            env_steps,
            until,
            envs,
            relay,
            exploration,
            replay,
            agent,
            evaluation,
        } = config;
        Self {
            version: *version,
            preset: *preset,
            seed: *seed,
            env_steps: *env_steps,
            until: *until,
            envs: *envs,
            task: TaskSection { name: task, options },
            randomize,
            relay,
            exploration,
            replay,
            agent,
            evaluation,
        }
    }
}

/// Who made a setting.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// The task's recipe.
    Recipe(Task),
    /// A file of the user's.
    File(PathBuf),
    /// `--set`.
    Set,
    /// An option of its own.
    Option(&'static str),
}

/// Where a setting was made.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Origin {
    pub(crate) source: Source,
    at: Option<Place>,
}

/// A place in a text, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    line: usize,
    column: usize,
}

impl Place {
    fn of(text: &str, offset: usize) -> Self {
        let before = &text[..offset];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        }
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.source {
            Source::Recipe(task) => write!(f, "recipe of {task}")?,
            Source::File(path) => write!(f, "{}", path.display())?,
            Source::Set => f.write_str("--set")?,
            Source::Option(name) => f.write_str(name)?,
        }
        match self.at {
            Some(Place { line, column }) => write!(f, ":{line}:{column}"),
            None => Ok(()),
        }
    }
}

/// Settings could not be put together.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SettingsError {
    #[error("cannot read config file `{}`", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{origin}: {problem}")]
    Syntax { origin: Origin, problem: String },
    #[error("{origin}: the file has version {found}, this program reads version {VERSION}")]
    Version { origin: Origin, found: i64 },
    #[error("{origin}: the file is for task `{found}`, not `{task}`")]
    OtherTask { origin: Origin, found: String, task: Task },
    #[error("{origin}: the file starts from another preset than --preset")]
    OtherPreset { origin: Origin },
    #[error("`{key}` cannot be changed by --set")]
    Fixed { key: String },
    #[error("{origin}: there is no setting `{key}`")]
    Unknown { origin: Origin, key: String, nearest: Option<String> },
    #[error("{origin}: `{key}` is a section, not a setting")]
    Section { origin: Origin, key: String },
    #[error("{origin}: `{key}`: {problem}")]
    Mistyped { origin: Origin, key: String, problem: String },
    #[error("{origin}: `{key}` is a setting of `{owner}`, not of `{task}`")]
    OtherTasksOption { origin: Origin, key: String, owner: Task, task: Task },
    #[error("{origin}: {error}")]
    OutOfRange { origin: Origin, error: ConfigError },
    #[error("{origin}: {error}")]
    Option { origin: Origin, error: OptionError },
    #[error(transparent)]
    Unfit(#[from] OptionError),
    #[error(transparent)]
    Combination(#[from] ConfigError),
    #[error("the settings do not fit into a TOML file")]
    Unwritten(#[from] toml::ser::Error),
}
