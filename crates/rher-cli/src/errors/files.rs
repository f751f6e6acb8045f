//! Files and standard output.

use super::report::{Explain, Report};
use crate::exit_code::Status;
use crate::printer::StdoutError;
use rher_core::files::{Access, FileError};
use std::io;

impl Explain for FileError {
    fn report(&self) -> Option<Report> {
        match self.access {
            Access::Read => None,
            Access::Write => Some(unwritable(&self.source)),
        }
    }
}

impl Explain for StdoutError {
    fn report(&self) -> Option<Report> {
        Some(unwritable(&self.0))
    }
}

fn unwritable(error: &io::Error) -> Report {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Report::new(
            Status::DiskFull,
            "free some space, and repeat the command; a run that had begun continues from its last \
             checkpoint with `rher train --resume DIR`",
        ),
        io::ErrorKind::InvalidFilename => Report::new(Status::Unwritable, "choose a shorter name"),
        io::ErrorKind::PermissionDenied
        | io::ErrorKind::ReadOnlyFilesystem
        | io::ErrorKind::NotFound
        | io::ErrorKind::NotADirectory
        | io::ErrorKind::IsADirectory
        | io::ErrorKind::AlreadyExists => {
            Report::new(Status::Unwritable, "choose a place where you have write permission")
        }
        _ => Report::new(
            Status::Unwritable,
            "the disk or its file system refused; when it works again, repeat the command; a run \
             that had begun continues from its last checkpoint with `rher train --resume DIR`",
        ),
    }
}
