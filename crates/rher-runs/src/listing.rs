//! The runs below a folder.

use crate::config_file::{CONFIG_FILE, ConfigFile, ConfigFileError};
use crate::folder::is_in_use;
use crate::metrics::{MetricsError, read_evaluations};
use crate::run::{Group, Header, RunError};
use rher_core::files::FileError;
use serde::{Deserialize, Serialize, Serializer};
use std::fs;
use std::path::{Path, PathBuf};

/// How deep below the given folder runs are looked for: `runs/sweep-push/relay.mirror=0/seed=1`.
const DEPTH: usize = 4;

/// A run that is there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Listed {
    /// Where it is.
    #[serde(serialize_with = "as_text")]
    pub folder: PathBuf,
    /// Task, method and preset.
    #[serde(flatten)]
    pub group: Group,
    /// Seed of every random draw.
    pub seed: u64,
    /// Environment steps before the latest evaluation.
    pub env_steps: u64,
    /// Success rate in the latest evaluation, if there was one.
    pub success_final: Option<f64>,
    /// What is known of its end.
    pub state: State,
    /// Size of all its files.
    pub bytes: u64,
}

/// Whether a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// A process trains it.
    Running,
    /// It reached its success rate.
    Solved,
    /// It took all of its steps.
    Spent,
    /// It can be resumed.
    Stopped,
}

impl State {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Solved => "solved",
            Self::Spent => "all steps taken",
            Self::Stopped => "stopped",
        }
    }
}

/// When a run ends; part of the settings.
#[derive(Deserialize)]
struct Ends {
    env_steps: u64,
    until: f64,
}

/// The runs in and below `folder`, in the order of their paths, and what cannot be read as one.
///
/// # Errors
///
/// If the folder itself cannot be read.
pub fn list(folder: &Path) -> Result<Vec<Result<Listed, RunError>>, FileError> {
    if folder.join(CONFIG_FILE).is_file() {
        return Ok(vec![read(folder)]);
    }
    let mut found = Vec::new();
    look_below(folder, DEPTH, &mut found)?;
    Ok(found)
}

fn look_below(
    folder: &Path,
    depth: usize,
    found: &mut Vec<Result<Listed, RunError>>,
) -> Result<(), FileError> {
    let mut folders = Vec::new();
    for entry in fs::read_dir(folder).map_err(FileError::read(folder))? {
        let entry = entry.map_err(FileError::read(folder))?;
        let path = entry.path();
        // A link may lead back to where it is.
        let is_loop = || {
            let (link, here) = (fs::canonicalize(&path), fs::canonicalize(folder));
            path.is_symlink()
                && link.is_ok_and(|link| here.is_ok_and(|here| here.starts_with(link)))
        };
        if path.is_dir() && !is_loop() {
            folders.push(path);
        }
    }
    folders.sort();
    for path in folders {
        if path.join(CONFIG_FILE).is_file() {
            found.push(read(&path));
        } else if depth > 1
            && let Err(error) = look_below(&path, depth - 1, found)
        {
            found.push(Err(error.into()));
        }
    }
    Ok(())
}

fn read(folder: &Path) -> Result<Listed, RunError> {
    let missing = || RunError::Missing { folder: folder.to_owned(), file: CONFIG_FILE };
    let file = ConfigFile::read(folder)?.ok_or_else(missing)?;
    let (id, settings) = (file.run, file.into_table());
    let damaged = |error: toml::de::Error| ConfigFileError::Damaged {
        path: folder.join(CONFIG_FILE),
        problem: error.message().to_owned(),
    };
    let Ends { env_steps: budget, until } = Ends::deserialize(settings.clone()).map_err(damaged)?;
    let (group, seed) = Header::deserialize(settings).map_err(damaged)?.into_parts();
    let evaluations = match read_evaluations(folder, id) {
        Err(MetricsError::Missing { .. }) => Vec::new(),
        evaluations => evaluations?,
    };
    let latest = evaluations.last();
    let env_steps = latest.map_or(0, |latest| latest.env_steps);
    let two = evaluations.last_chunk::<2>();
    let is_solved = until > 0.0 && two.is_some_and(|two| two.iter().all(|it| it.reaches(until)));
    let state = match () {
        () if is_in_use(folder) => State::Running,
        () if is_solved => State::Solved,
        () if env_steps >= budget => State::Spent,
        () => State::Stopped,
    };
    Ok(Listed {
        folder: folder.to_owned(),
        group,
        seed,
        env_steps,
        success_final: latest.map(|latest| latest.success_final),
        state,
        bytes: size(folder).map_err(FileError::read(folder))?,
    })
}

/// Names of folders may be no text.
fn as_text<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&path.display())
}

/// Bytes of all files in and below a folder.
fn size(folder: &Path) -> std::io::Result<u64> {
    let mut bytes = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        bytes += if metadata.is_dir() { size(&entry.path())? } else { metadata.len() };
    }
    Ok(bytes)
}
