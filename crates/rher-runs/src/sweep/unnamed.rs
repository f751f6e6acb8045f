//! Files that get their name when they are whole, by a hard link: of several processes, on whatever
//! machines, one makes the file.

use rher_core::files::{FileError, is_absent};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// A file that does not have its name yet.
pub(super) struct Unnamed {
    pub(super) file: File,
    /// Where it is until then.
    pub(super) path: PathBuf,
}

impl Unnamed {
    /// A new file in `folder` that no other process has. Its name begins with `start`.
    pub(super) fn create(folder: &Path, start: &str) -> Result<Self, FileError> {
        for number in 0_u64.. {
            let path = folder.join(format!("{start}{}-{number}", std::process::id()));
            match File::create_new(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(FileError::write(&path)(error)),
                Ok(file) => return Ok(Self { file, path }),
            }
        }
        unreachable!("some number is free")
    }

    /// Gives it the name `path`; `None` if another process was faster.
    pub(super) fn name(self, path: &Path) -> Result<Option<File>, FileError> {
        let linked = std::fs::hard_link(&self.path, path);
        // Some network file systems say that the name is there when it is this very file.
        let is_ours = linked.is_ok() || has_two_names(&self.file);
        // The process that was faster may have removed it.
        let _ = std::fs::remove_file(&self.path);
        match linked {
            _ if is_ours => Ok(Some(self.file)),
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists && !is_absent(&error) => {
                Err(FileError::write(path)(error))
            }
            _ => Ok(None),
        }
    }
}

#[cfg(unix)]
fn has_two_names(file: &File) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    file.metadata().is_ok_and(|file| file.nlink() > 1)
}

#[cfg(not(unix))]
fn has_two_names(_: &File) -> bool {
    false
}

/// Whether a file of this name is an [`Unnamed`] one whose name begins with `start`.
pub(super) fn is_unnamed(name: &str, start: &str) -> bool {
    let numbers = name.strip_prefix(start).and_then(|rest| rest.split_once('-'));
    numbers.is_some_and(|(a, b)| a.parse::<u32>().is_ok() && b.parse::<u64>().is_ok())
}

/// Removes the files in `folder` whose names are ones that `is_meant` takes. Other processes may
/// remove them, too.
pub(super) fn remove_where(
    folder: &Path,
    is_meant: impl Fn(&str) -> bool,
) -> Result<(), FileError> {
    for entry in std::fs::read_dir(folder).map_err(FileError::read(folder))? {
        let entry = entry.map_err(FileError::read(folder))?;
        if entry.file_name().to_str().is_some_and(&is_meant) {
            match std::fs::remove_file(entry.path()) {
                Err(error) if !is_absent(&error) => {
                    return Err(FileError::write(&entry.path())(error));
                }
                _ => {}
            }
        }
    }
    Ok(())
}
