//! Runs as they are compared: what each reached and when, in groups that differ by the seed alone.

use crate::folder::{CONFIG_FILE, METRICS_FILE};
use rher_core::files::FileError;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use toml::Table;

/// A run, read from its folder.
#[derive(Clone, Debug)]
pub struct Run {
    /// What it has in common with the other seeds.
    pub group: Group,
    /// Seed of every random draw.
    pub seed: u64,
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
    /// Name of the preset.
    pub preset: String,
}

/// What one line of metrics says of success.
#[derive(Clone, Debug, Deserialize)]
pub struct Evaluation {
    /// Environment steps of training before it.
    pub env_steps: u64,
    /// Seconds of training before it.
    pub wall_s: f64,
    /// Success rate of each sub-task; `None` where it is not trained. At least one.
    pub success: Vec<Option<f64>>,
    /// Success rate of the whole task.
    pub success_final: f64,
}

/// What is read of the settings, whatever version of the program wrote them.
#[derive(Deserialize)]
struct Header {
    task: Task,
    preset: String,
    seed: u64,
    relay: Relay,
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
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// Nothing was evaluated yet.
    #[error("`{}` has no metrics yet: expected a line for each evaluation", path.display())]
    NoMetrics {
        /// The file.
        path: PathBuf,
    },
    /// A line of the metrics is not what was written.
    #[error("line {line} of `{}` is damaged: {problem}", path.display())]
    Metrics {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// The settings are not those of a run.
    #[error("`{}` does not hold the settings of a run: {problem}", path.display())]
    Settings {
        /// The file.
        path: PathBuf,
        /// What is wrong with them.
        problem: String,
    },
}

impl Run {
    /// Reads the run in a folder, finished or not.
    ///
    /// # Errors
    ///
    /// If its settings or its metrics are missing or damaged, or if nothing was evaluated yet.
    pub fn read(folder: &Path) -> Result<Self, RunError> {
        let (path, text) = read(folder, CONFIG_FILE)?;
        let invalid = |error: toml::de::Error| RunError::Settings {
            path: path.clone(),
            problem: error.message().to_owned(),
        };
        let mut settings: Table = toml::from_str(&text).map_err(invalid)?;
        let Header { task, preset, seed, relay } =
            Header::deserialize(settings.clone()).map_err(invalid)?;
        for key in ["seed", "env_steps", "until"] {
            settings.remove(key);
        }
        let evaluations = read_evaluations(folder)?;
        let (Task::Section { name: task } | Task::Name(task)) = task;
        let group = Group { task, method: relay.method, preset };
        Ok(Self { group, seed, settings, evaluations })
    }

    /// The last evaluation.
    pub fn last(&self) -> &Evaluation {
        &self.evaluations[self.evaluations.len() - 1]
    }
}

impl Evaluation {
    /// Whether the whole task succeeded at least this often.
    pub fn reaches(&self, rate: f64) -> bool {
        // Rates are written with the digits of a single-precision number.
        const ROUNDING: f64 = 1e-6;
        self.success_final >= rate - ROUNDING
    }

    /// Whether this can follow `before` in the metrics of a run; if not, what is wrong.
    fn check(&self, before: Option<&Self>) -> Result<(), String> {
        if self.success.is_empty() {
            return Err("`success` is empty, expected a rate for each sub-task".to_owned());
        }
        let rates = self.success.iter().copied().flatten().chain([self.success_final]);
        if let Some(rate) = rates.into_iter().find(|rate| !(0.0..=1.0).contains(rate)) {
            return Err(format!("a success rate is {rate}, expected 0 to 1"));
        }
        if !(self.wall_s.is_finite() && self.wall_s >= 0.0) {
            return Err(format!("`wall_s` is {}, expected at least 0", self.wall_s));
        }
        match before {
            Some(before) if before.env_steps > self.env_steps => Err(format!(
                "`env_steps` is {}, expected at least the {} of the line before",
                self.env_steps, before.env_steps
            )),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { task, method, preset } = self;
        write!(f, "{task} {method} {preset}")
    }
}

/// Reads runs and sorts them into groups: by task, and then in the order in which they are named.
///
/// # Errors
///
/// If one of them cannot be read.
pub fn read_groups(folders: &[PathBuf]) -> Result<Vec<(Group, Vec<Run>)>, RunError> {
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

/// The evaluations of a run, in the order in which they were made; at least one.
///
/// # Errors
///
/// If its metrics are missing or damaged, or if nothing was evaluated yet.
pub fn read_evaluations(folder: &Path) -> Result<Vec<Evaluation>, RunError> {
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
            _ => FileError::read(&path)(source).into(),
        }),
    }
}

/// Complete lines; a run that is being written may end in a part of one.
fn parse(text: &str) -> Result<Vec<Evaluation>, (usize, String)> {
    let complete = text.rfind('\n').map_or("", |end| &text[..end]);
    let mut evaluations: Vec<Evaluation> = Vec::new();
    for (index, line) in complete.lines().enumerate() {
        let damaged = |problem| (index + 1, problem);
        let evaluation: Evaluation =
            serde_json::from_str(line).map_err(|error| damaged(error.to_string()))?;
        evaluation.check(evaluations.last()).map_err(damaged)?;
        evaluations.push(evaluation);
    }
    Ok(evaluations)
}
