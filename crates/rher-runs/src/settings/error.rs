//! What can be wrong with settings, and who made them.

use super::describe::expected;
use rher_core::config::{ConfigError, VERSION};
use rher_core::train::memory::MemoryError;
use rher_envs::{OptionError, Task};
use std::fmt;
use std::io;
use std::path::PathBuf;

/// Who made a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
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
pub struct Origin {
    /// Who made it.
    pub source: Source,
    pub(super) at: Option<Place>,
}

/// A place in a text, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    line: usize,
    column: usize,
}

impl Place {
    pub(super) fn of(text: &str, offset: usize) -> Self {
        let before = &text[..offset];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        }
    }
}

impl From<Source> for Origin {
    fn from(source: Source) -> Self {
        Self { source, at: None }
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
pub enum SettingsError {
    /// The file system refused.
    #[error("cannot read config file `{}`", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// The file is not TOML.
    #[error("{origin}: {problem}")]
    Syntax {
        /// Where.
        origin: Origin,
        /// What the parser said.
        problem: String,
    },
    /// The file is of another version.
    #[error("{origin}: the file has version {found}, this program reads version {VERSION}")]
    Version {
        /// Where it says so.
        origin: Origin,
        /// The version.
        found: i64,
    },
    /// The file is of another task.
    #[error("{origin}: the file is for task `{found}`, not `{task}`")]
    OtherTask {
        /// Where it says so.
        origin: Origin,
        /// Its task.
        found: String,
        /// The task that is trained.
        task: String,
    },
    /// The file and the arguments disagree about the preset.
    #[error("{origin}: the file starts from another preset than --preset")]
    OtherPreset {
        /// Where the file names its own.
        origin: Origin,
    },
    /// The key is not a setting but what the settings are for.
    #[error("`{key}` cannot be changed by --set")]
    Fixed {
        /// Dotted.
        key: String,
    },
    /// The key is a setting, but not one of the environments.
    #[error("--set: `{key}` is no setting of the environments, expected `randomize.…` or `task.…`")]
    NotOfEnvironments {
        /// Dotted.
        key: String,
    },
    /// The key is a fact about the run that another one started from.
    #[error("{origin}: `{key}` says which run another one started from, and cannot be set")]
    StartedFrom {
        /// Who asked for it.
        origin: Origin,
        /// Dotted.
        key: String,
    },
    /// The key is not known.
    #[error("{origin}: there is no setting `{key}`")]
    Unknown {
        /// Who asked for it.
        origin: Origin,
        /// Dotted.
        key: String,
        /// What it may have been meant to be.
        nearest: Option<String>,
    },
    /// The key has settings below it.
    #[error("{origin}: `{key}` is a section, not a setting")]
    Section {
        /// Who asked for it.
        origin: Origin,
        /// Dotted.
        key: String,
    },
    /// The value has another type, or is too large for it.
    #[error("{origin}: `{key}` is {value}, expected {expected}")]
    Mistyped {
        /// Who asked for it.
        origin: Origin,
        /// Dotted.
        key: String,
        /// Its value, as TOML.
        value: Box<str>,
        /// The values that it accepts.
        expected: Box<str>,
    },
    /// Only another task has this setting.
    #[error("{origin}: `{key}` is a setting of `{owner}`, not of `{task}`")]
    OtherTasksOption {
        /// Who asked for it.
        origin: Origin,
        /// Dotted.
        key: String,
        /// The task that has it.
        owner: Task,
        /// The task that is trained.
        task: Task,
    },
    /// A setting is outside its range.
    #[error("{origin}: {error}")]
    OutOfRange {
        /// Who asked for it.
        origin: Origin,
        /// What is allowed.
        error: ConfigError,
    },
    /// An option of the environments is outside its range.
    #[error("{origin}: {error}")]
    Option {
        /// Who asked for it.
        origin: Origin,
        /// What is allowed.
        error: OptionError,
    },
    /// Options of the environments are wrong, and nobody asked for them.
    #[error(transparent)]
    Unfit(#[from] OptionError),
    /// Settings do not go together.
    #[error(transparent)]
    Combination(#[from] ConfigError),
    /// A run with these settings needs more memory than there is.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// Settings cannot be written down.
    #[error("the settings do not fit into a TOML file")]
    Unwritten(#[from] toml::ser::Error),
}

impl SettingsError {
    /// The error of a setting that has another type than `value`.
    pub(super) fn mistyped(origin: Origin, key: &str, value: &toml::Value) -> Self {
        let expected = expected(key).unwrap_or_else(|| "another type".to_owned()).into();
        Self::Mistyped { origin, key: key.to_owned(), value: value.to_string().into(), expected }
    }
}
