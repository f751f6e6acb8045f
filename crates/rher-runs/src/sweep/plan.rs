//! A plan: every run of a sweep, in a file that any machine can take one from.

use super::unnamed::{Unnamed, is_unnamed, remove_where};
use crate::settings::{self, Settings, SettingsError};
use rher_core::files::{self, FileError};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::collections::HashSet;
use std::fmt;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Component, Path, PathBuf};
use toml::Table;

#[cfg(test)]
mod tests;

/// The version of the format that this program writes and reads.
const VERSION: u64 = 1;

/// Largest plan in bytes; a cell has about 2,000.
const LARGEST: u64 = 1 << 30;

/// Every run of a sweep.
///
/// The file is JSON Lines: a first line about the plan, and a line for each cell.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Where it is read from or written to.
    path: PathBuf,
    id: PlanId,
    cells: Vec<Cell>,
}

/// One run of a plan.
#[derive(Clone, Debug)]
pub struct Cell {
    /// What it is one of several seeds of, such as `push relay.mirror=0`.
    pub group: String,
    /// Its folder, from that of the plan, or from the root.
    pub folder: PathBuf,
    /// All of them, with the task and the seed.
    pub settings: Settings,
}

/// Identity of a plan: a hash of its cells.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct PlanId(String);

impl fmt::Display for PlanId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A plan cannot be written or used.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its first line is not that of a plan.
    #[error("`{}` is no plan: {problem}", path.display())]
    NotPlan {
        /// The file.
        path: PathBuf,
        /// What is wrong with its first line.
        problem: String,
    },
    /// It has another version.
    #[error(
        "`{}` is a plan of version {found}, made by {made_by}; expected version {VERSION}",
        path.display()
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u64,
        /// The program that made it.
        made_by: String,
    },
    /// It is not what was written.
    #[error("`{}` is damaged: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where, and what is wrong.
        problem: String,
    },
    /// The settings of a cell were changed.
    #[error(
        "the settings of cell {cell} in `{}` do not match their hash: it is {found}, expected \
         {expected}",
        path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// Number of the cell.
        cell: usize,
        /// Hash of the settings that are there.
        found: String,
        /// Hash of the settings that were written.
        expected: String,
    },
    /// It has no such cell.
    #[error("`{}` has no cell {cell}: its cells are 0 to {last}", path.display())]
    NoCell {
        /// The file.
        path: PathBuf,
        /// The number that was asked for.
        cell: u64,
        /// The last one that there is.
        last: usize,
    },
    /// There is another file in its place.
    #[error("`{}` is there already, and it is not the plan that would be written", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The settings of a cell cannot be written.
    #[error(transparent)]
    Settings(#[from] SettingsError),
}

/// The first line.
#[derive(Serialize, Deserialize)]
struct Header {
    /// The version.
    plan: u64,
    made_by: String,
    id: PlanId,
    cells: usize,
}

impl Header {
    fn line(&self) -> String {
        serde_json::to_string(self).expect("numbers and text are JSON") + "\n"
    }
}

/// The line of a cell.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    cell: usize,
    task: String,
    seed: u64,
    group: String,
    folder: String,
    hash: String,
    settings: Value,
}

impl Plan {
    /// Writes a plan. One that is there already and is the same is left alone.
    ///
    /// # Errors
    ///
    /// If another file is there, or if the file system refuses.
    pub fn write(path: &Path, cells: Vec<Cell>) -> Result<Self, PlanError> {
        let mut lines = String::new();
        for (number, cell) in cells.iter().enumerate() {
            lines += &line(number, cell)?;
            lines.push('\n');
        }
        let id = PlanId(hash(lines.as_bytes()));
        let made_by = concat!("rher ", env!("CARGO_PKG_VERSION")).to_owned();
        let header = Header { plan: VERSION, made_by, id: id.clone(), cells: cells.len() };
        let plan = Self { path: path.to_owned(), id, cells };
        plan.make_file((header.line() + &lines).as_bytes())?;
        Ok(plan)
    }

    /// Sees to it that the file of this plan is there.
    fn make_file(&self, bytes: &[u8]) -> Result<(), PlanError> {
        let path = &self.path;
        // Another process may make the file, or remove it, between two looks.
        for _ in 0..10 {
            match Self::read(path) {
                Ok(there) if there.id == self.id => return Ok(remove_unfinished(path)?),
                Err(PlanError::File(error)) if error.source.kind() == io::ErrorKind::NotFound => {
                    if create(path, bytes)? {
                        return Ok(());
                    }
                }
                Err(PlanError::File(error)) => return Err(error.into()),
                Ok(_) | Err(_) => break,
            }
        }
        Err(PlanError::Exists { path: path.clone() })
    }

    /// Reads a plan.
    ///
    /// # Errors
    ///
    /// If it is no plan, has another version, or is not what was written.
    pub fn read(path: &Path) -> Result<Self, PlanError> {
        Self::parse(path, files::read_at_most(path, LARGEST)?)
    }

    fn parse(path: &Path, bytes: Vec<u8>) -> Result<Self, PlanError> {
        let not_plan =
            |problem: &str| PlanError::NotPlan { path: path.to_owned(), problem: problem.into() };
        let text = String::from_utf8(bytes).map_err(|_| not_plan("it is no text"))?;
        let (first, rest) = text.split_once('\n').unwrap_or((&text, ""));
        let header: Value = serde_json::from_str(first)
            .map_err(|_| not_plan("its first line is not the JSON that begins a plan"))?;
        let version = header.get("plan").and_then(Value::as_u64);
        let version = version.ok_or_else(|| not_plan("its first line has no version `plan`"))?;
        if version != VERSION {
            let made_by = header.get("made_by").and_then(Value::as_str);
            let made_by = made_by.unwrap_or("an unknown program").to_owned();
            return Err(PlanError::Version { path: path.to_owned(), found: version, made_by });
        }
        let damaged = |problem: String| PlanError::Damaged { path: path.to_owned(), problem };
        let Header { id, cells: expected, .. } =
            serde_json::from_value(header).map_err(|error| damaged(format!("line 1: {error}")))?;
        let mut cells = Vec::new();
        for (number, text) in rest.lines().enumerate() {
            cells.push(read_line(path, number, text)?);
        }
        if cells.len() != expected || expected == 0 {
            return Err(damaged(format!("it has {} cells, expected {expected}", cells.len())));
        }
        let mut folders = HashSet::new();
        if let Some(cell) = cells.iter().position(|cell| !folders.insert(&cell.folder)) {
            return Err(damaged(format!("cell {cell} has the folder of another cell")));
        }
        let found = hash(rest.as_bytes());
        if found != id.0 {
            return Err(damaged(format!(
                "the hash of its cells is {found}, expected {id}: its lines are not those that \
                 were written"
            )));
        }
        Ok(Self { path: path.to_owned(), id, cells })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its identity, which is a hash of its cells.
    pub fn id(&self) -> &PlanId {
        &self.id
    }

    /// Every cell, in the order of their numbers.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The cell with this number.
    ///
    /// # Errors
    ///
    /// If there is none.
    pub fn cell(&self, number: u64) -> Result<(usize, &Cell), PlanError> {
        let index = usize::try_from(number).unwrap_or(usize::MAX);
        let cell = self.cells.get(index).map(|cell| (index, cell));
        let last = self.cells.len().saturating_sub(1);
        cell.ok_or_else(|| PlanError::NoCell { path: self.path.clone(), cell: number, last })
    }

    /// Where a cell is trained.
    pub fn folder(&self, cell: &Cell) -> PathBuf {
        folder_of(&self.path).join(&cell.folder)
    }
}

/// The name of `folder` from the folder of the plan, if it is below it; from the root if it is not.
///
/// # Errors
///
/// If the operating system does not say where this program is.
pub fn from_plan(plan: &Path, folder: &Path) -> Result<PathBuf, FileError> {
    let (plan, to) = (absolute(plan)?, absolute(folder)?);
    Ok(to.strip_prefix(folder_of(&plan)).map_or_else(|_| to.clone(), Path::to_owned))
}

/// A path from the root, without `..`.
fn absolute(path: &Path) -> Result<PathBuf, FileError> {
    let path = std::path::absolute(path).map_err(FileError::read(path))?;
    Ok(path.components().fold(PathBuf::new(), |before, part| match part {
        // What is above a link is not what stands before it in the path.
        Component::ParentDir => {
            let mut before = before.canonicalize().unwrap_or(before);
            before.pop();
            before
        }
        part => before.join(part),
    }))
}

fn folder_of(plan: &Path) -> &Path {
    plan.parent().unwrap_or(Path::new(""))
}

/// The same, as the operating system wants it.
fn existing_folder_of(plan: &Path) -> &Path {
    let folder = folder_of(plan);
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// Writes a file that is complete or absent; `false` if another process was faster.
fn create(path: &Path, bytes: &[u8]) -> Result<bool, FileError> {
    let folder = existing_folder_of(path);
    let mut new = Unnamed::create(folder, &unfinished(path))?;
    let written = new.file.write_all(bytes).and_then(|()| files::sync(&new.file));
    if let Err(error) = written {
        // The error that matters is the one before.
        let _ = std::fs::remove_file(&new.path);
        return Err(FileError::write(path)(error));
    }
    let is_made = new.name(path)?.is_some();
    if is_made {
        let synced = File::open(folder).and_then(|folder| files::sync(&folder));
        synced.map_err(FileError::write(folder))?;
        remove_unfinished(path)?;
    }
    Ok(is_made)
}

/// How the names of files begin that were to become the plan at `path`.
fn unfinished(path: &Path) -> String {
    format!(".{}-", path.file_name().unwrap_or_default().display())
}

/// Removes what processes left that were killed while they wrote the plan at `path`. It is there, so
/// nobody needs what others have not finished yet.
fn remove_unfinished(path: &Path) -> Result<(), FileError> {
    let start = unfinished(path);
    remove_where(existing_folder_of(path), |name| is_unnamed(name, &start))
}

/// The line of a cell.
fn line(number: usize, cell: &Cell) -> Result<String, PlanError> {
    let text = settings::to_toml(&cell.settings)?;
    let table: Table = text.parse().expect("TOML that was just written can be read");
    let line = Line {
        cell: number,
        task: cell.settings.config.task.clone(),
        seed: cell.settings.config.seed,
        group: cell.group.clone(),
        folder: cell.folder.display().to_string(),
        hash: hash(text.as_bytes()),
        settings: serde_json::to_value(table).expect("settings have no dates"),
    };
    Ok(serde_json::to_string(&line).expect("a table with text as keys is JSON"))
}

/// Reads the line of cell `number`.
fn read_line(path: &Path, number: usize, text: &str) -> Result<Cell, PlanError> {
    let damaged = |problem: &dyn fmt::Display| PlanError::Damaged {
        path: path.to_owned(),
        problem: format!("line {}: {problem}", number + 2),
    };
    let Line { cell, task, seed, group, folder, hash: expected, settings } =
        serde_json::from_str(text).map_err(|error| damaged(&error))?;
    if cell != number {
        return Err(damaged(&format!("it is cell {cell}, expected cell {number}")));
    }
    let table: Table = serde_json::from_value(settings).map_err(|error| damaged(&error))?;
    let settings = settings::from_table(table).map_err(|error| damaged(&error.message()))?;
    let found = hash(settings::to_toml(&settings)?.as_bytes());
    if found != expected {
        return Err(PlanError::Changed { path: path.to_owned(), cell, found, expected });
    }
    if (&settings.config.task, settings.config.seed) != (&task, seed) {
        return Err(damaged(&"its task and its seed are not those of its settings"));
    }
    let folder = PathBuf::from(folder);
    let is_plain = |part| matches!(part, Component::Normal(_) | Component::RootDir);
    if folder.as_os_str().is_empty() || !folder.components().all(is_plain) {
        return Err(damaged(&format!("`{}` is no folder of a cell", folder.display())));
    }
    Ok(Cell { group, folder, settings })
}

/// The first 128 bits of a SHA-256, as 32 digits.
fn hash(bytes: &[u8]) -> String {
    let digits = Sha256::digest(bytes);
    digits[..16].iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}
