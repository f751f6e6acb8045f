//! Recordings and datasets.

use super::report::{Explain, Report};
use crate::exit_code::Status;
use rher_core::files::FileError;
use rher_record::export::ExportError;
use rher_record::{PlayError, ReadError};
use std::io;

impl Explain for ReadError {
    fn report(&self) -> Option<Report> {
        const MADE: &str = "`rher play RUN --mcap FILE` makes a recording";
        let hint = match self {
            Self::File(FileError { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                MADE.into()
            }
            Self::File(error) => return error.report(),
            Self::NotMcap { .. } | Self::Foreign { .. } => MADE.into(),
            Self::CutOff { path, whole: 0 } => {
                format!("no episode in `{}` is complete; record it again", path.display())
            }
            Self::CutOff { path, .. } => format!(
                "its whole episodes can be read if it is named `{}`; copy the file again if it was \
                 complete",
                path.with_extension("part.mcap").display()
            ),
            Self::Info { .. } => "read it with the version of `rher` that made it".into(),
            Self::Damaged { .. } | Self::Empty { .. } => "record it again".into(),
        };
        Some(Report::new(Status::Recording, hint))
    }
}

impl Explain for PlayError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Rollout(error) => error.report(),
            Self::Misfit { .. } => Some(Report::new(
                Status::Recording,
                "the recording is of another task than it names, or of another version of the task",
            )),
        }
    }
}

impl Explain for ExportError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Exists { .. } => Some(Report::new(
                Status::Unwritable,
                "choose another folder with --out, or remove this one",
            )),
            Self::File(error) => error.report(),
            Self::Table { .. } | Self::Empty { .. } => Some(Report::plain(Status::Failure)),
            Self::Widths { .. } => Some(Report::new(
                Status::Recording,
                "the recording was put together from recordings of different tasks",
            )),
        }
    }
}

#[cfg(feature = "live")]
impl Explain for rher_record::LiveError {
    fn report(&self) -> Option<Report> {
        Some(Report::new(Status::Address, "`--live=127.0.0.1:0` takes any free port"))
    }
}
