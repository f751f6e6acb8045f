//! From what is asked for to the settings of a run.

use super::file::ConfigFile;
use super::layers::Layers;
use super::{Asked, Settings, SettingsError, Source};
use rher_core::config::{Preset, TrainConfig};
use rher_core::train::memory::{self, MemoryError};
use rher_envs::{EnvVisitor, Options, Simulated, Task};
use toml::Value;

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

/// The options of environments of `task` that have `options`, but for what is `set`.
///
/// # Errors
///
/// If something is set that is no setting of these environments.
pub fn resolve_options(
    task: Task,
    options: &Options,
    set: &[(String, Value)],
) -> Result<Options, SettingsError> {
    let config = Preset::Fast.config(task.name(), task.objects());
    let mut layers = Layers::new(Some(task), Settings { config, options: options.clone() })?;
    layers.set_options(set)?;
    Ok(layers.finish()?.options)
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
