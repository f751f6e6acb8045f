//! Runs as they are compared: what each reached and when, in groups that differ by the seed alone.

use rher_runs::{CONFIG_FILE, METRICS_FILE};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use toml::Table;

/// A run, from its folder.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) group: Group,
    pub(crate) seed: u64,
    /// Every setting but the seed and when to end.
    pub(crate) settings: Table,
    /// By time; at least one.
    pub(crate) evaluations: Vec<Evaluation>,
}

/// What runs have in common that differ by the seed alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Group {
    pub(crate) task: String,
    pub(crate) method: String,
    pub(crate) preset: String,
}

/// What one line of metrics says of success.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Evaluation {
    pub(crate) env_steps: u64,
    pub(crate) wall_s: f64,
    /// By sub-task; `None` where it is not trained.
    pub(crate) success: Vec<Option<f64>>,
    pub(crate) success_final: f64,
}

/// What is read of the settings, whatever version of the program wrote them.
#[derive(Deserialize)]
struct Settings {
    task: Task,
    preset: String,
    seed: u64,
    relay: Relay,
}

/// Settings of a task have a section of their own; earlier programs wrote the name alone.
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
pub(crate) enum RunError {
    #[error("`{}` holds no run: there is no `{file}` in it", folder.display())]
    Missing { folder: PathBuf, file: &'static str },
    #[error("cannot read `{}`", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("`{}` has no metrics yet: expected a line for each evaluation", path.display())]
    NoMetrics { path: PathBuf },
    #[error("line {line} of `{}` is damaged: {problem}", path.display())]
    Metrics { path: PathBuf, line: usize, problem: String },
    #[error("`{}` has other settings than a run's: {problem}", path.display())]
    Settings { path: PathBuf, problem: String },
}

impl Run {
    /// Reads the run in a folder, finished or not.
    pub(crate) fn read(folder: &Path) -> Result<Self, RunError> {
        let (path, text) = read(folder, CONFIG_FILE)?;
        let invalid = |error: toml::de::Error| RunError::Settings {
            path: path.clone(),
            problem: error.message().to_owned(),
        };
        let mut settings: Table = toml::from_str(&text).map_err(invalid)?;
        let Settings { task, preset, seed, relay } =
            Settings::deserialize(settings.clone()).map_err(invalid)?;
        for key in ["seed", "env_steps", "until"] {
            settings.remove(key);
        }
        let evaluations = read_evaluations(folder)?;
        let (Task::Section { name: task } | Task::Name(task)) = task;
        let group = Group { task, method: relay.method, preset };
        Ok(Self { group, seed, settings, evaluations })
    }

    /// The last evaluation.
    pub(crate) fn last(&self) -> &Evaluation {
        &self.evaluations[self.evaluations.len() - 1]
    }
}

impl Evaluation {
    /// Whether the whole task succeeded at least this often.
    pub(crate) fn reaches(&self, rate: f64) -> bool {
        // Rates are written with the digits of a single-precision number.
        const ROUNDING: f64 = 1e-6;
        self.success_final >= rate - ROUNDING
    }
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { task, method, preset } = self;
        write!(f, "{task} {method} {preset}")
    }
}

/// Reads runs and sorts them into groups: by task, and then in the order in which they are named.
pub(crate) fn read_groups(folders: &[PathBuf]) -> Result<Vec<(Group, Vec<Run>)>, RunError> {
    let mut groups: Vec<(Group, Vec<Run>)> = Vec::new();
    for folder in folders {
        let run = Run::read(folder)?;
        if let Some((_, runs)) = groups.iter_mut().find(|(group, _)| *group == run.group) {
            runs.push(run);
        } else {
            let same_task = groups.iter().rposition(|(group, _)| group.task == run.group.task);
            let place = same_task.map_or(groups.len(), |last| last + 1);
            groups.insert(place, (run.group.clone(), vec![run]));
        }
    }
    Ok(groups)
}

/// The evaluations of a run, by time; at least one.
pub(crate) fn read_evaluations(folder: &Path) -> Result<Vec<Evaluation>, RunError> {
    let (path, text) = read(folder, METRICS_FILE)?;
    match parse(&text) {
        Ok(evaluations) if evaluations.is_empty() => Err(RunError::NoMetrics { path }),
        Ok(evaluations) => Ok(evaluations),
        Err((line, problem)) => Err(RunError::Metrics { path, line, problem }),
    }
}

fn read(folder: &Path, file: &'static str) -> Result<(PathBuf, String), RunError> {
    let path = folder.join(file);
    match std::fs::read_to_string(&path) {
        Ok(text) => Ok((path, text)),
        Err(source) => Err(match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
                RunError::Missing { folder: folder.to_owned(), file }
            }
            _ => RunError::Read { path, source },
        }),
    }
}

/// Complete lines; a run that is being written may end in a part of one.
fn parse(text: &str) -> Result<Vec<Evaluation>, (usize, String)> {
    let complete = text.rfind('\n').map_or("", |end| &text[..end]);
    complete
        .lines()
        .enumerate()
        .map(|(index, line)| {
            serde_json::from_str(line).map_err(|error| (index + 1, error.to_string()))
        })
        .collect()
}
