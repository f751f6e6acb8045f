//! Folders of runs, and what lies in them.

use super::report::{Explain, Report};
use crate::exit_code::Status;
use crate::shell::word;
use rher_runs::{
    ConfigFileError, MetricsError, OtherSettings, RunDirError, RunError, RunFilesError, State, list,
};
use std::path::Path;

impl Explain for RunFilesError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Folder(error) => error.report(),
            Self::Metrics(error) => error.report(),
            Self::File(error) => error.report(),
        }
    }
}

/// Most runs that a hint names.
const NAMED: usize = 8;

/// A hint for whoever named a run that is not there, and the names of runs that are.
pub(super) fn and_there(hint: &str) -> String {
    let runs = list(Path::new("runs")).unwrap_or_default();
    let named = runs.iter().flatten().take(NAMED);
    let mut names: Vec<String> = named.map(|run| format!("`{}`", run.folder.display())).collect();
    match runs.len() {
        0 => return hint.to_owned(),
        count if count > NAMED => names.push("those that `rher runs` lists".to_owned()),
        _ => {}
    }
    format!("{hint}; there are {}", names.join(", "))
}

/// Whether there is nothing more to do in the run of this folder.
fn is_finished(path: &Path) -> bool {
    let runs = list(path).unwrap_or_default();
    let mut states = runs.iter().flatten().map(|run| run.state);
    states.any(|state| matches!(state, State::Solved | State::Spent))
}

impl Explain for RunDirError {
    fn report(&self) -> Option<Report> {
        let hint = match self {
            Self::InUse { .. } => {
                "wait until that process ends, or choose another folder with --out".to_owned()
            }
            Self::Exists { path } => {
                let more = if is_finished(path) { " --env-steps N" } else { "" };
                format!(
                    "`rher train --resume {}{more}` continues it; `--out DIR` starts a run elsewhere",
                    word(path)
                )
            }
            Self::Gone { .. } => {
                let hint = "what was saved before is where the folder is now; there, `rher train \
                            --resume DIR` continues the run";
                return Some(Report::new(Status::FolderGone, hint));
            }
            Self::NoRun { .. } => and_there("`rher train <TASK> --out DIR` starts a run"),
            Self::File(error) => return error.report(),
            Self::Settings(error) => return error.report(),
        };
        Some(Report::new(Status::RunFolder, hint))
    }
}

impl Explain for OtherSettings {
    fn report(&self) -> Option<Report> {
        Some(Report::new(
            Status::RunFolder,
            "choose another folder with --out, or give the settings of the runs that are there",
        ))
    }
}

impl Explain for MetricsError {
    fn report(&self) -> Option<Report> {
        let hint = match self {
            Self::TooShort { .. } | Self::Missing { .. } => {
                "restore the file, or start a new run with --out"
            }
            Self::Damaged { .. } => "restore the file, or leave this run out",
            Self::File(error) => return error.report(),
        };
        Some(Report::new(Status::Damaged, hint))
    }
}

impl Explain for ConfigFileError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Damaged { .. } => Some(Report::new(
                Status::Damaged,
                "restore the file, or read the run with the version of `rher` that made it; \
                 without the file, the settings in the checkpoint count",
            )),
            Self::File(error) => error.report(),
        }
    }
}

impl Explain for RunError {
    fn report(&self) -> Option<Report> {
        let (status, hint) = match self {
            Self::Missing { .. } => {
                let hint = "give a folder that `rher train` made: it has `config.toml` and `metrics.jsonl`";
                return Some(Report::new(Status::RunFolder, and_there(hint)));
            }
            Self::NoMetrics { .. } => {
                (Status::RunFolder, "wait for its first evaluation, or leave this run out")
            }
            Self::Metrics(error) => return error.report(),
            Self::Config(error) => return error.report(),
            Self::File(_) => (Status::RunFolder, "check that you may read the file"),
        };
        Some(Report::new(status, hint))
    }
}
