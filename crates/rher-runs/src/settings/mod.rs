//! Settings of a run: preset < recipe of the task < `--config` < `--set` < other options.

mod error;

pub use error::{Origin, SettingsError, Source};

use error::Place;
use rher_core::config::{AgentConfig, EngineKind};
use rher_core::config::{
    EvaluationConfig, ExplorationConfig, Method, Preset, RelayConfig, ReplayConfig, TrainConfig,
    VERSION,
};
use rher_envs::{EnvVisitor, Options, Randomize, Simulated, Task, TaskOptions};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue, ValueDeserializer};
use toml::{Table, Value};

/// Settings that `--set` leaves alone.
const FIXED: [&str; 4] = ["version", "task", "task.name", "preset"];

/// Everything that is part of an experiment: how it is learned, and in which environments.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How it is learned.
    pub config: TrainConfig,
    /// What is set about the environments.
    pub options: Options,
}

/// What should differ from the defaults.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Where to start from.
    pub preset: Option<Preset>,
    /// A settings file.
    pub config: Option<PathBuf>,
    /// Single settings, by dotted key.
    pub set: Vec<(String, Value)>,
    /// Which method is trained.
    pub method: Option<Method>,
    /// Seed of every random draw.
    pub seed: Option<u64>,
    /// Environment steps after which training ends.
    pub env_steps: Option<u64>,
    /// Success rate that ends the run early.
    pub until: Option<f32>,
    /// Who does the arithmetic.
    pub engine: Option<EngineKind>,
    /// Environments stepped side by side.
    pub envs: Option<u64>,
}

/// The settings of a run on one of our tasks.
pub fn resolve(task: Task, asked: &Asked) -> Result<Settings, SettingsError> {
    let file = asked.config.as_deref().map(ConfigFile::read).transpose()?;
    if let Some(file) = &file {
        file.check_task(task.name())?;
    }
    let preset = preset(asked, file.as_ref())?;
    let config = preset.config(task.name(), task.visit(Objects));
    let settings = Settings { config, options: Options::of(task.options()) };
    let mut layers = Layers::new(Some(task), settings)?;
    if let (Preset::Fast, Some(recipe)) = (preset, recipe(task)) {
        layers.set_all(ConfigFile::parse(&Source::Recipe(task), recipe)?.entries)?;
    }
    layers.ask(file, asked)?;
    layers.finish()
}

/// The settings of a run on an environment that someone else made, with `objects` objects.
pub fn resolve_foreign(
    name: &str,
    objects: usize,
    asked: &Asked,
) -> Result<TrainConfig, SettingsError> {
    let file = asked.config.as_deref().map(ConfigFile::read).transpose()?;
    if let Some(file) = &file {
        file.check_task(name)?;
    }
    let config = preset(asked, file.as_ref())?.config(name, objects);
    let mut layers = Layers::new(None, Settings { config, options: Options::default() })?;
    layers.ask(file, asked)?;
    Ok(layers.finish()?.config)
}

/// The preset to start from.
fn preset(asked: &Asked, file: Option<&ConfigFile>) -> Result<Preset, SettingsError> {
    match file {
        Some(file) => file.preset(asked.preset),
        None => Ok(asked.preset.unwrap_or(Preset::Fast)),
    }
}

/// Settings that reach the success rate on a task sooner, or with a better budget, than the
/// preset alone.
fn recipe(task: Task) -> Option<&'static str> {
    match task {
        Task::Reach => Some(include_str!("../../../../recipes/reach.toml")),
        Task::Slide => Some(include_str!("../../../../recipes/slide.toml")),
        Task::ObstaclePush => Some(include_str!("../../../../recipes/obstacle-push.toml")),
        Task::TStack => Some(include_str!("../../../../recipes/tstack.toml")),
        Task::CuePush => Some(include_str!("../../../../recipes/cue-push.toml")),
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

    fn check_task(&self, task: &str) -> Result<(), SettingsError> {
        match self.entry(NAME) {
            Some(Entry { value: Value::String(found), origin, .. }) if found != task => {
                let (origin, found, task) = (origin.clone(), found.clone(), task.to_owned());
                Err(SettingsError::OtherTask { origin, found, task })
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
    /// None if the environment is someone else's, about which nothing can be set.
    task: Option<Task>,
    table: Table,
    settings: Settings,
    origins: BTreeMap<String, Origin>,
}

impl Layers {
    fn new(task: Option<Task>, settings: Settings) -> Result<Self, SettingsError> {
        let mut table = Table::try_from(SettingsFile::of(&settings))?;
        if task.is_none() {
            table.remove("randomize");
        }
        Ok(Self { task, table, settings, origins: BTreeMap::new() })
    }

    /// Sets what the user asks for.
    fn ask(&mut self, file: Option<ConfigFile>, asked: &Asked) -> Result<(), SettingsError> {
        let Asked { preset: _, config: _, set, method, seed, env_steps, until, engine, envs } =
            asked;
        if let Some(file) = file {
            self.set_all(file.entries)?;
        }
        for (key, value) in set {
            if FIXED.contains(&key.as_str()) {
                return Err(SettingsError::Fixed { key: key.clone() });
            }
            self.set(Entry::new(key, value.clone(), Source::Set))?;
        }
        let options = [
            ("relay.method", "--method", method.map(|method| method.name().into())),
            ("seed", "--seed", seed.map(|seed| Value::Integer(seed.cast_signed()))),
            ("env_steps", "--env-steps", env_steps.map(|n| Value::Integer(n.cast_signed()))),
            ("until", "--until", until.map(|rate| Value::Float(rate.into()))),
            ("agent.engine", "--engine", engine.map(Value::try_from).transpose()?),
            ("envs", "--envs", envs.map(|envs| Value::Integer(envs.cast_signed()))),
        ];
        for (key, option, value) in options {
            if let Some(value) = value {
                self.set(Entry::new(key, value, Source::Option(option)))?;
            }
        }
        Ok(())
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
                if let (Some(task), Some(owner)) = (self.task, owner(&entry.key)) {
                    let (origin, key) = (entry.origin, entry.key);
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
pub fn to_toml(settings: &Settings) -> Result<String, SettingsError> {
    Ok(toml::to_string(&SettingsFile::of(settings))?)
}

/// The settings in a file that [`to_toml`] made, if they can be read.
pub fn from_toml(text: &str) -> Option<Settings> {
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
            objects: _,
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
