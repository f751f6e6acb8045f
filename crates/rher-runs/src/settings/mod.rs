//! Settings of a run: preset < recipe of the task < `--config` < `--set` < other options.

mod describe;
mod error;
mod file;
mod layers;
mod reference;
mod written;

pub use describe::{Described, described, list};
pub use error::{Origin, SettingsError, Source};
pub use file::{LARGEST_FILE, read_text};
pub use reference::reference;
pub use written::{Comments, from_toml, to_toml, to_toml_with};

use file::ConfigFile;
use layers::Layers;
use rher_core::config::{EngineKind, Method, Preset, TrainConfig};
use rher_core::train::memory::{self, MemoryError};
use rher_envs::{EnvVisitor, Options, Simulated, Task};
use std::path::PathBuf;
use toml::Value;

/// Everything that is part of an experiment: how the agent learns, and in which environments.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How the agent learns.
    pub config: TrainConfig,
    /// Settings of the environments.
    pub options: Options,
}

/// Settings that the user asks for.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Preset to start from.
    pub preset: Option<Preset>,
    /// A settings file.
    pub config: Option<PathBuf>,
    /// Single settings, by dotted key.
    pub set: Vec<(String, Value)>,
    /// Training method.
    pub method: Option<Method>,
    /// Seed of every random draw.
    pub seed: Option<u64>,
    /// Environment steps after which training ends.
    pub env_steps: Option<u64>,
    /// Success rate at which training ends early.
    pub until: Option<f32>,
    /// Compute engine of the networks.
    pub engine: Option<EngineKind>,
    /// Environments stepped side by side.
    pub envs: Option<u64>,
}

/// The settings of a run on one of our tasks.
pub fn resolve(task: Task, asked: &Asked) -> Result<Settings, SettingsError> {
    let file = read(asked, task.name())?;
    let preset = preset(asked, file.as_ref())?;
    let config = preset.config(task.name(), task.objects());
    let settings = Settings { config, options: Options::of(task.options()) };
    let mut layers = Layers::new(Some(task), settings)?;
    if let (Preset::Fast, Some(recipe)) = (preset, task.recipe()) {
        layers.set_all(&ConfigFile::parse(Source::Recipe(task), recipe.to_owned())?)?;
    }
    layers.ask(file, asked)?;
    layers.finish()
}

/// The same for a run on this machine, which must have the memory that it needs.
pub fn resolve_here(task: Task, asked: &Asked) -> Result<Settings, SettingsError> {
    let settings = resolve(task, asked)?;
    let Settings { config, options } = &settings;
    task.visit_with(options, CheckMemory(config)).map_err(SettingsError::Unfit)??;
    Ok(settings)
}

/// Checks that this machine has the memory for a run on one of our tasks.
struct CheckMemory<'a>(&'a TrainConfig);

impl EnvVisitor for CheckMemory<'_> {
    type Output = Result<(), MemoryError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        memory::check(self.0, build().spec())
    }
}

/// The settings of a run on an environment that someone else made, with `objects` objects.
pub fn resolve_foreign(
    name: &str,
    objects: usize,
    asked: &Asked,
) -> Result<TrainConfig, SettingsError> {
    let file = read(asked, name)?;
    let config = preset(asked, file.as_ref())?.config(name, objects);
    let mut layers = Layers::new(None, Settings { config, options: Options::default() })?;
    layers.ask(file, asked)?;
    Ok(layers.finish()?.config)
}

/// The settings file that was asked for, which must be for this task.
fn read(asked: &Asked, task: &str) -> Result<Option<ConfigFile>, SettingsError> {
    let file = asked.config.as_deref().map(ConfigFile::read).transpose()?;
    if let Some(file) = &file {
        file.check_task(task)?;
    }
    Ok(file)
}

/// The preset to start from.
fn preset(asked: &Asked, file: Option<&ConfigFile>) -> Result<Preset, SettingsError> {
    match file {
        Some(file) => file.preset(asked.preset),
        None => Ok(asked.preset.unwrap_or(Preset::Fast)),
    }
}
