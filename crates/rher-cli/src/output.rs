//! Files for the user that are complete or not there.

use rher_runs::WriteError;
use std::ffi::OsString;
use std::path::Path;

/// Writes `bytes` to a new file beside `path`, and gives it that name when it is complete.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.new", std::process::id()));
    let new = path.with_file_name(name);
    std::fs::write(&new, bytes).and_then(|()| std::fs::rename(&new, path)).map_err(|source| {
        // Where there is none, nothing was written.
        let _ = std::fs::remove_file(&new);
        WriteError { path: path.to_owned(), source }
    })
}
