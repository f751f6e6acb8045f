//! Temporary names: what is written has one of its own until it is whole.

use rher_core::files::is_at;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// A file or folder under a temporary name that no other process uses.
///
/// The name is held by a lock, which dies with the process: what a killed process left behind is
/// replaced. Where the file system has no locks, a name that is taken stays taken.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) path: PathBuf,
    lock: Option<File>,
}

impl Part {
    /// A new, empty file under the first of `names` that is free, open for writing.
    pub(crate) fn file(names: impl Iterator<Item = PathBuf>) -> io::Result<(Self, File)> {
        let part = first(
            names,
            |path| File::create_new(path).map(Some),
            |path| std::fs::remove_file(path),
        )?;
        let file = part.lock.as_ref().expect("made with its file").try_clone()?;
        Ok((part, file))
    }

    /// The length of the file.
    pub(crate) fn bytes(&self) -> io::Result<u64> {
        std::fs::metadata(&self.path).map(|file| file.len())
    }

    /// A new, empty folder under the first of `names` that is free.
    pub(crate) fn folder(names: impl Iterator<Item = PathBuf>) -> io::Result<Self> {
        let create = |path: &Path| {
            std::fs::create_dir(path)?;
            // A folder cannot be opened on every system; there its name alone is what protects it.
            Ok(File::open(path).ok())
        };
        first(names, create, |path| std::fs::remove_dir_all(path))
    }
}

fn first(
    names: impl Iterator<Item = PathBuf>,
    create: impl Fn(&Path) -> io::Result<Option<File>>,
    remove: impl Fn(&Path) -> io::Result<()>,
) -> io::Result<Part> {
    for path in names {
        match claim(&path, &create, &remove) {
            Ok(lock) => return Ok(Part { path, lock }),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Makes `path`, in place of what a killed process left there.
fn claim(
    path: &Path,
    create: impl Fn(&Path) -> io::Result<Option<File>>,
    remove: impl Fn(&Path) -> io::Result<()>,
) -> io::Result<Option<File>> {
    let made = match create(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            let left = File::open(path)?;
            if !matches!(left.try_lock(), Ok(())) || !is_at(path, &left)? {
                return Err(error);
            }
            remove(path)?;
            create(path)
        }
        made => made,
    }?;
    // Another process may take a new file for one that was left behind, before it is locked.
    let taken = made.as_ref().is_some_and(|file| {
        matches!(file.try_lock(), Err(TryLockError::WouldBlock))
            || !is_at(path, file).unwrap_or(false)
    });
    if taken { Err(io::ErrorKind::AlreadyExists.into()) } else { Ok(made) }
}
