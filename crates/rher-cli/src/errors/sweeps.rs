//! Plans and their cells.

use super::report::{Explain, Report};
use crate::exit_code::Status;
use rher_core::files::FileError;
use rher_runs::sweep::{AttemptError, ClaimError, Lost, PlanError};
use std::fmt;
use std::io;

/// An environment variable does not say which cell is meant.
#[derive(Debug, thiserror::Error)]
#[error("the environment variable `{variable}` {}", Found(found.as_deref()))]
pub(crate) struct NoCellNumber {
    pub(crate) variable: String,
    /// Its value, if it has one.
    pub(crate) found: Option<String>,
}

struct Found<'a>(Option<&'a str>);

impl fmt::Display for Found<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => f.write_str("is not set, expected the number of a cell"),
            Some(value) => write!(f, "is `{value}`, expected the number of a cell"),
        }
    }
}

impl Explain for NoCellNumber {
    fn report(&self) -> Option<Report> {
        Some(Report::new(
            Status::Usage,
            "Slurm sets SLURM_ARRAY_TASK_ID in the jobs of an array, Kubernetes JOB_COMPLETION_INDEX \
             in those of an Indexed Job; `--cell K` names a cell itself",
        ))
    }
}

impl Explain for PlanError {
    fn report(&self) -> Option<Report> {
        const WRITE: &str = "`rher sweep TASK... --plan FILE` writes a plan";
        Some(match self {
            Self::File(FileError { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                Report::new(Status::ConfigFile, WRITE)
            }
            Self::File(error) => return error.report(),
            Self::NotPlan { .. } => Report::new(Status::ConfigFile, WRITE),
            Self::Version { .. } => Report::new(
                Status::ConfigVersion,
                "use it with the version of `rher` that made it, or write a new plan in another file",
            ),
            Self::Damaged { .. } => Report::new(
                Status::Damaged,
                "restore the file, or write the plan again in another file; a plan is not edited",
            ),
            Self::Changed { .. } => Report::new(
                Status::Damaged,
                "restore the line; other settings are another plan: `rher sweep TASK... --plan FILE` \
                 writes it, with another folder in --out",
            ),
            Self::NoCell { .. } => Report::new(Status::Usage, "cells are counted from 0"),
            Self::Exists { .. } => {
                Report::new(Status::Unwritable, "choose another file, or remove this one")
            }
            Self::Settings(error) => return error.report(),
        })
    }
}

impl Explain for ClaimError {
    fn report(&self) -> Option<Report> {
        Some(match self {
            Self::Busy { .. } => Report::new(
                Status::Busy,
                "leave the cell to it; if it dies, the same command continues the cell",
            ),
            Self::Owned { .. } => Report::new(
                Status::RunFolder,
                "write the plan with another folder in --out, or remove that folder",
            ),
            Self::Attempt(error) => return error.report(),
        })
    }
}

impl Explain for AttemptError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::File(error) => error.report(),
            Self::Damaged { .. } => Some(Report::new(
                Status::Damaged,
                "make sure that no process trains there, and remove the file; the run is kept in \
                 the other files",
            )),
        }
    }
}

impl Explain for Lost {
    fn report(&self) -> Option<Report> {
        Some(Report::new(
            Status::Busy,
            "nothing more was written; the other worker continues from the last checkpoint",
        ))
    }
}
