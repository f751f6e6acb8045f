//! A dataset on disk: complete or absent, whatever its format.

use super::demonstration::Demonstration;
use super::error::{ExportError, unwritable};
use super::lerobot::Lerobot;
use super::minari::{DatasetId, Minari};
use crate::RecordingInfo;
use crate::part::Part;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

/// A dataset that is being written, one episode at a time.
///
/// Until it is finished it lies beside its place, with `.part` in its name; what is dropped before
/// that is removed.
pub struct Dataset {
    folder: PartFolder,
    path: PathBuf,
    kind: Kind,
    widths: Option<[usize; 3]>,
}

/// Whose format a dataset has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DatasetFormat {
    /// Minari's, in its Parquet storage, under this identity.
    Minari(DatasetId),
    /// LeRobot's, version 3.0, without pictures.
    Lerobot,
}

enum Kind {
    Minari(Minari),
    Lerobot(Lerobot),
}

impl Dataset {
    /// Starts a dataset that will have this path, of episodes with this description.
    ///
    /// # Errors
    ///
    /// If there is something at `path`, or no folder can be made beside it.
    pub fn create(
        path: &Path,
        format: DatasetFormat,
        info: &RecordingInfo,
    ) -> Result<Self, ExportError> {
        if path.exists() {
            return Err(ExportError::Exists { path: path.to_owned() });
        }
        let folder = PartFolder::beside(path).map_err(unwritable(path))?;
        let kind = match format {
            DatasetFormat::Minari(id) => Kind::Minari(Minari::new(id, info.clone())),
            DatasetFormat::Lerobot => Kind::Lerobot(Lerobot::new(info)),
        };
        Ok(Self { folder, path: path.to_owned(), kind, widths: None })
    }

    /// Adds an episode.
    ///
    /// # Errors
    ///
    /// If it has other widths than the first one, or the files cannot be written.
    pub fn add(&mut self, demonstration: &Demonstration) -> Result<(), ExportError> {
        let found = demonstration.widths();
        let expected = *self.widths.get_or_insert(found);
        if found != expected {
            return Err(ExportError::Widths { seed: demonstration.seed, found, expected });
        }
        match &mut self.kind {
            Kind::Minari(minari) => minari.add(self.folder.path(), demonstration),
            Kind::Lerobot(lerobot) => lerobot.add(self.folder.path(), demonstration),
        }
    }

    /// Gives the dataset its name.
    ///
    /// # Errors
    ///
    /// If there is no episode in it, something has taken its place, or the files cannot be written.
    pub fn finish(self) -> Result<(), ExportError> {
        let Self { folder, path, kind, widths } = self;
        let Some(widths) = widths else { return Err(ExportError::Empty { path }) };
        match kind {
            Kind::Minari(minari) => minari.finish(folder.path(), widths)?,
            Kind::Lerobot(lerobot) => lerobot.finish(folder.path())?,
        }
        match folder.rename(&path) {
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::AlreadyExists
                        | io::ErrorKind::DirectoryNotEmpty
                        | io::ErrorKind::NotADirectory
                ) =>
            {
                Err(ExportError::Exists { path })
            }
            renamed => renamed.map_err(unwritable(&path)),
        }
    }
}

/// A folder under a temporary name, which is removed unless it is renamed.
struct PartFolder(Option<Part>);

impl PartFolder {
    fn beside(path: &Path) -> io::Result<Self> {
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        let named = |end: String| {
            let mut name = OsString::from(path.file_name().unwrap_or_default());
            name.push(end);
            path.with_file_name(name)
        };
        let names = std::iter::once(".part".to_owned())
            .chain((2..1000).map(|n| format!(".{n}.part")))
            .map(named);
        Part::folder(names).map(|part| Self(Some(part)))
    }

    fn path(&self) -> &Path {
        self.0.as_ref().map_or(Path::new(""), |part| &part.path)
    }

    fn rename(mut self, path: &Path) -> io::Result<()> {
        std::fs::rename(self.path(), path)?;
        self.0 = None;
        Ok(())
    }
}

impl Drop for PartFolder {
    fn drop(&mut self) {
        if let Some(part) = &self.0 {
            let _ = std::fs::remove_dir_all(&part.path);
        }
    }
}
