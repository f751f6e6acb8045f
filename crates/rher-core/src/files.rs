//! Files that are complete or absent, and the one error of files.

use std::fmt;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What was tried with a file or a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Reading it.
    Read,
    /// Making it, writing it, renaming it or deleting it.
    Write,
}

impl fmt::Display for Access {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Write => "write",
        })
    }
}

/// The operating system refused to read or write a file or a folder.
#[derive(Debug, thiserror::Error)]
#[error("cannot {access} `{}`", path.display())]
pub struct FileError {
    /// What was tried.
    pub access: Access,
    /// The file or folder.
    pub path: PathBuf,
    /// What the operating system said.
    pub source: io::Error,
}

impl FileError {
    /// The error of a file that cannot be read, as `map_err` takes it.
    pub fn read(path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self { access: Access::Read, path: path.to_owned(), source }
    }

    /// The error of a file or folder that cannot be written, as `map_err` takes it.
    pub fn write(path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self { access: Access::Write, path: path.to_owned(), source }
    }
}

/// Writes `bytes` to `path`: to a temporary file in the same folder, synced, then renamed, so that
/// the file is complete or as it was before.
///
/// # Errors
///
/// If the operating system refuses to make, write, sync or rename the file.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    try_replace(path, bytes).map_err(FileError::write(path))
}

fn try_replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = folder(path);
    let mut file = named(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    File::open(folder)?.sync_all()
}

/// A temporary file that others may read as they may any new file.
#[cfg(unix)]
fn named(folder: &Path) -> io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt as _;
    const AS_THE_UMASK_ALLOWS: u32 = 0o666;
    let permissions = std::fs::Permissions::from_mode(AS_THE_UMASK_ALLOWS);
    tempfile::Builder::new().permissions(permissions).tempfile_in(folder)
}

#[cfg(not(unix))]
fn named(folder: &Path) -> io::Result<NamedTempFile> {
    NamedTempFile::new_in(folder)
}

/// Makes the renames in a folder durable.
#[cfg(feature = "train")]
pub(crate) fn sync_folder(folder: &Path) -> Result<(), FileError> {
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(FileError::write(folder))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
