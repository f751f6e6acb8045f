//! Files that are complete or absent, and the one error of files.

use std::fmt;
use std::fs::File;
use std::io::{self, Read as _, Write as _};
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

/// The bytes of a file that has at most `largest` of them, which a file that never ends has not.
///
/// # Errors
///
/// Those of the operating system, and [`io::ErrorKind::FileTooLarge`].
pub fn read_at_most(path: &Path, largest: u64) -> Result<Vec<u8>, FileError> {
    read_from(path, 0, |_| true, largest)
}

/// The same for a file whose first `start` bytes tell whether it is one that is meant: if it is
/// not, only these are read.
pub(crate) fn read_from(
    path: &Path,
    start: u64,
    is_meant: impl Fn(&[u8]) -> bool,
    largest: u64,
) -> Result<Vec<u8>, FileError> {
    let read = || {
        let (mut bytes, file) = (Vec::new(), File::open(path)?);
        (&file).take(start).read_to_end(&mut bytes)?;
        if !is_meant(&bytes) {
            return Ok(bytes);
        }
        (&file).take((largest - start).saturating_add(1)).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > largest {
            let problem = format!("it has more than the {largest} bytes that are expected");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, problem));
        }
        Ok(bytes)
    };
    read().map_err(FileError::read(path))
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
            .and_then(|()| sync(&file))
            .and_then(|()| std::fs::rename(&new, path));
        written.inspect_err(|_| {
            // The error that matters is the one before.
            let _ = std::fs::remove_file(&new);
        })
    });
    written.map_err(FileError::write(path))?;
    sync_folder(folder)
}

/// How the names of files that [`replace`] has not renamed yet begin and end.
const UNFINISHED: (&str, &str) = (".rher-", ".new");

/// Removes the files in `folder` that a killed process did not finish. Nobody else may be writing
/// there.
///
/// # Errors
///
/// If the operating system refuses to list or to remove them.
pub fn remove_unfinished(folder: &Path) -> Result<(), FileError> {
    let (start, end) = UNFINISHED;
    for entry in std::fs::read_dir(folder).map_err(FileError::read(folder))? {
        let entry = entry.map_err(FileError::read(folder))?;
        let name = entry.file_name();
        let is_ours = |name: &str| name.starts_with(start) && name.ends_with(end);
        if name.to_str().is_some_and(is_ours) {
            std::fs::remove_file(entry.path()).map_err(FileError::write(&entry.path()))?;
        }
    }
    Ok(())
}

/// A new file with a short name that no other process or thread uses.
fn create_beside(folder: &Path) -> io::Result<(File, PathBuf)> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let (start, end) = UNFINISHED;
        let path = folder.join(format!("{start}{}-{number}{end}", std::process::id()));
        match File::create_new(&path) {
            // Another machine or a killed process may have used the same number.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            file => return Ok((file?, path)),
        }
    }
}

/// Makes what was written to a file or a folder durable, where the file system can do that: some
/// network file systems cannot, and then nothing can be done about it here.
///
/// # Errors
///
/// If the operating system says that something may not be on disk.
pub fn sync(file: &File) -> io::Result<()> {
    match file.sync_all() {
        Err(error) if is_unsupported(&error) => Ok(()),
        synced => synced,
    }
}

fn is_unsupported(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput)
}

/// Whether `file` is what `path` names now.
///
/// # Errors
///
/// Those of the operating system, except that a `path` which names nothing is an answer.
pub fn is_at(path: &Path, file: &File) -> io::Result<bool> {
    match same_file(path, file) {
        Err(error) if is_absent(&error) => Ok(false),
        answer => answer,
    }
}

#[cfg(unix)]
fn same_file(path: &Path, file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;
    let (there, held) = (std::fs::metadata(path)?, file.metadata()?);
    Ok((there.dev(), there.ino()) == (held.dev(), held.ino()))
}

#[cfg(not(unix))]
fn same_file(path: &Path, file: &File) -> io::Result<bool> {
    use same_file::Handle;
    Ok(Handle::from_path(path)? == Handle::from_file(file.try_clone()?)?)
}

/// Whether a path names nothing: it is not there, or something on the way to it is no folder.
pub fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// Makes the renames in a folder durable. Windows cannot open a folder for that.
pub(crate) fn sync_folder(folder: &Path) -> Result<(), FileError> {
    if cfg!(windows) {
        return Ok(());
    }
    File::open(folder).and_then(|folder| sync(&folder)).map_err(FileError::write(folder))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
