//! Why a dataset cannot be written.

use parquet::errors::ParquetError;
use rher_core::files::FileError;
use std::io;
use std::path::{Path, PathBuf};

/// A dataset cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Something is in its place already.
    #[error("`{}` exists already", path.display())]
    Exists {
        /// Where it should be.
        path: PathBuf,
    },
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// A table could not be put together.
    #[error("cannot write a table of `{}`", path.display())]
    Table {
        /// The dataset.
        path: PathBuf,
        /// What is wrong.
        source: ParquetError,
    },
    /// Episodes do not fit together.
    #[error(
        "the episode of seed {seed} has {found:?} numbers in an observation, a goal and an action, \
         expected {expected:?} as in the first episode"
    )]
    Widths {
        /// Seed of the episode.
        seed: u64,
        /// Its widths.
        found: [usize; 3],
        /// Widths of the first episode.
        expected: [usize; 3],
    },
    /// No episode was added.
    #[error("there is no episode to write to `{}`", path.display())]
    Empty {
        /// Where the dataset should be.
        path: PathBuf,
    },
}

/// The error of a file that cannot be written, as `map_err` takes it.
pub(super) fn unwritable(path: &Path) -> impl Fn(io::Error) -> ExportError {
    let refused = FileError::write(path);
    move |source| refused(source).into()
}

/// Writes a file and the folders that it lies in.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(unwritable(path))?;
    }
    std::fs::write(path, bytes).map_err(unwritable(path))
}
