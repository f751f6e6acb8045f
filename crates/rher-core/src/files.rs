//! Files that are complete or absent, and the one error of files.

use std::fmt;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

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

/// Writes `bytes` to `path`: to a new file in the same folder, synced, then renamed, so that the
/// file is complete or as it was before.
///
/// # Errors
///
/// If the operating system refuses to make, write, sync or rename the file.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let folder = folder(path);
    let written = create_beside(folder).and_then(|(mut file, new)| {
        let written = file
            .write_all(bytes)
            .and_then(|()| file.sync_all())
            .and_then(|()| std::fs::rename(&new, path));
        written.inspect_err(|_| {
            // The error that matters is the one before.
            let _ = std::fs::remove_file(&new);
        })
    });
    written.map_err(FileError::write(path))?;
    sync_folder(folder)
}

/// A new file with a short name that no other process or thread uses.
fn create_beside(folder: &Path) -> io::Result<(File, PathBuf)> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!(".rher-{}-{number}.new", std::process::id()));
        match File::create_new(&path) {
            // Another machine or a killed process may have used the same number.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            file => return Ok((file?, path)),
        }
    }
}

/// Makes the renames in a folder durable.
pub(crate) fn sync_folder(folder: &Path) -> Result<(), FileError> {
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(FileError::write(folder))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
