//! Runs as they are compared: what each reached and when, in groups that differ by the seed alone.

use crate::config_file::{CONFIG_FILE, ConfigFile, ConfigFileError};
use crate::metrics::{Evaluation, METRICS_FILE, MetricsError, read_evaluations};
use rher_core::RunId;
use rher_core::files::FileError;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};
use toml::Table;

/// A run, read from its folder.
#[derive(Clone, Debug)]
pub struct Run {
    /// Where it was read.
    pub folder: PathBuf,
    /// What it has in common with the other seeds.
    pub group: Group,
    /// Seed of every random draw.
    pub seed: u64,
    /// Its identity; earlier versions did not write it.
    pub id: Option<RunId>,
    /// Every setting but the seed, `env_steps` and `until`.
    pub settings: Table,
    /// In the order in which they were made; at least one.
    pub evaluations: Vec<Evaluation>,
}

/// What runs have in common that differ by the seed alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Group {
    /// Name of the task.
    pub task: String,
    /// Name of the method.
    pub method: String,
    /// Name of the preset, and what a plan varies.
    pub preset: String,
}

/// What is read of the settings, whatever version of the program wrote them.
#[derive(Deserialize)]
pub(crate) struct Header {
    task: Task,
    preset: String,
    seed: u64,
    relay: Relay,
}

impl Header {
    /// What the run has in common with the other seeds, and its seed.
    pub(crate) fn into_parts(self) -> (Group, u64) {
        let Self { task, preset, seed, relay } = self;
        let (Task::Section { name: task } | Task::Name(task)) = task;
        (Group { task, method: relay.method, preset }, seed)
    }
}

/// A task has a section of settings; earlier versions wrote its name alone.
#[derive(Deserialize)]
#[serde(untagged)]
enum Task {
    Section { name: String },
    Name(String),
}

#[derive(Deserialize)]
struct Relay {
    method: String,
}

/// A folder cannot be read as a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A file of a run is missing.
    #[error("`{}` holds no run: there is no `{file}` in it", folder.display())]
    Missing {
        /// The folder.
        folder: PathBuf,
        /// The file.
        file: &'static str,
    },
    /// Nothing was evaluated yet.
    #[error("`{}` has no metrics yet: expected a line for each evaluation", path.display())]
    NoMetrics {
        /// The file.
        path: PathBuf,
    },
    /// The metrics cannot be read.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// The settings cannot be read.
    #[error(transparent)]
    Config(#[from] ConfigFileError),
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
}

impl Run {
    /// Reads the run in a folder, finished or not.
    ///
    /// # Errors
    ///
    /// If its settings or its metrics are missing or damaged, or if nothing was evaluated yet.
    pub fn read(folder: &Path) -> Result<Self, RunError> {
        let missing = |file| RunError::Missing { folder: folder.to_owned(), file };
        let file = ConfigFile::read(folder)?.ok_or_else(|| missing(CONFIG_FILE))?;
        let id = file.run;
        let mut settings = file.into_table();
        let header =
            Header::deserialize(settings.clone()).map_err(|error| ConfigFileError::Damaged {
                path: folder.join(CONFIG_FILE),
                problem: error.message().to_owned(),
            })?;
        let (group, seed) = header.into_parts();
        for key in ["seed", "env_steps", "until"] {
            settings.remove(key);
        }
        let evaluations = match read_evaluations(folder, id) {
            Ok(evaluations) if evaluations.is_empty() => {
                return Err(RunError::NoMetrics { path: folder.join(METRICS_FILE) });
            }
            Err(MetricsError::Missing { .. }) => return Err(missing(METRICS_FILE)),
            evaluations => evaluations?,
        };
        Ok(Self { folder: folder.to_owned(), group, seed, id, settings, evaluations })
    }

    /// Whether this is the same run as `other`, perhaps at another time.
    fn is_same(&self, other: &Self) -> bool {
        if let (Some(id), Some(other)) = (self.id, other.id) {
            return id == other;
        }
        let same_seed = (self.seed, &self.group) == (other.seed, &other.group);
        same_seed && self.settings == other.settings
    }

    /// The last evaluation.
    pub fn last(&self) -> &Evaluation {
        &self.evaluations[self.evaluations.len() - 1]
    }
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { task, method, preset } = self;
        write!(f, "{task} {method} {preset}")
    }
}

/// Runs in groups that differ by the seed alone.
#[derive(Clone, Debug)]
pub struct Groups {
    /// By task, and then in the order in which they are named.
    pub groups: Vec<(Group, Vec<Run>)>,
    /// Folders that hold a run that is in the groups already.
    pub repeated: Vec<Repeated>,
}

/// A folder that holds the run of another folder: the same settings and the same seed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repeated {
    /// The folder, which is left out.
    pub folder: PathBuf,
    /// The folder that counts.
    pub counted: PathBuf,
}

impl Groups {
    /// Sorts runs into groups. A run that is there more than once, in one folder or in several, counts
    /// once: with its longest metrics.
    pub fn of(runs: Vec<Run>) -> Self {
        let mut repeated = Vec::new();
        let mut counted: Vec<Run> = Vec::new();
        for mut run in runs {
            let Some(known) = counted.iter_mut().find(|known| known.is_same(&run)) else {
                counted.push(run);
                continue;
            };
            if known.evaluations.len() < run.evaluations.len() {
                std::mem::swap(known, &mut run);
            }
            repeated.push(Repeated { folder: run.folder, counted: known.folder.clone() });
        }
        let mut groups: Vec<(Group, Vec<Run>)> = Vec::new();
        for run in counted {
            if let Some((_, runs)) = groups.iter_mut().find(|(group, _)| *group == run.group) {
                runs.push(run);
            } else {
                let same_task = groups.iter().rposition(|(group, _)| group.task == run.group.task);
                let place = same_task.map_or(groups.len(), |last| last + 1);
                groups.insert(place, (run.group.clone(), vec![run]));
            }
        }
        Self { groups, repeated }
    }
}
