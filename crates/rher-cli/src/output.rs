//! Files that are written at once, where the user says.

use rher_core::files::{self, FileError};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Writes a file that is complete or not there. What is no regular file, such as a pipe, is written
/// to instead of replaced, and a link stays a link.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let path = &target(path)?;
    match fs::metadata(path) {
        Ok(there) if !there.is_file() => fs::write(path, bytes).map_err(FileError::write(path)),
        _ => files::replace(path, bytes),
    }
}

/// What a path leads to, if it is a link to something.
pub(crate) fn target(path: &Path) -> Result<PathBuf, FileError> {
    match fs::canonicalize(path) {
        Ok(target) if path.is_symlink() => Ok(target),
        Err(error) if error.kind() != ErrorKind::NotFound => Err(FileError::write(path)(error)),
        _ => Ok(path.to_owned()),
    }
}
