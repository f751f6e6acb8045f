//! Errors of this program itself.

use super::report::{Explain, Report};
use crate::exit_code::Status;
use rher_core::RunId;
use rher_envs::TaskNameError;
use rher_record::verify::Difference;
use std::path::PathBuf;

/// A run, a policy or a recording is of a task that is not part of this program.
#[derive(Debug, thiserror::Error)]
#[error("it was made for task `{name}`, which is not part of this program")]
pub(crate) struct ForeignTask {
    pub(crate) name: String,
}

impl Explain for ForeignTask {
    fn report(&self) -> Option<Report> {
        let hint = "`rher tasks` lists the tasks of this program; a task of your own is known to \
                    your own program";
        Some(Report::new(Status::Usage, hint))
    }
}

impl Explain for TaskNameError {
    fn report(&self) -> Option<Report> {
        Some(Report::plain(Status::Usage))
    }
}

/// Environments of a task cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[error("environments of `{task}` cannot be drawn: they name nothing that can be seen")]
pub(crate) struct Invisible {
    pub(crate) task: &'static str,
}

impl Explain for Invisible {
    fn report(&self) -> Option<Report> {
        let hint = "implement `rher_envs::Simulated::things` for them; `--mcap` records positions \
                    without it";
        Some(Report::new(Status::Usage, hint))
    }
}

/// This machine computes other bits than all others.
#[derive(Debug, thiserror::Error)]
#[error(
    "this machine computes other bits than every other machine: {task} differs first in {part}"
)]
pub(crate) struct OtherBits {
    pub(crate) task: &'static str,
    pub(crate) part: &'static str,
}

impl Explain for OtherBits {
    fn report(&self) -> Option<Report> {
        let hint = "`docs/determinism.md` says what keeps them the same; please report what \
                    `rher doctor --bits --json` prints";
        Some(Report::new(Status::Failure, hint))
    }
}

/// An option of `rher export` is for another format.
#[derive(Debug, thiserror::Error)]
#[error("`{option}` is for {formats}: {reason}")]
pub(crate) struct OtherFormat {
    option: &'static str,
    formats: &'static str,
    reason: &'static str,
}

impl OtherFormat {
    /// LeRobot's datasets have no place for an identity.
    pub(crate) const NO_IDENTITY: Self = Self {
        option: "--dataset-id",
        formats: "`--format minari`",
        reason: "a LeRobot dataset does not contain an identity",
    };

    /// An option for datasets is given for a model.
    pub(crate) const fn of_dataset(option: &'static str) -> Self {
        let reason = "an ONNX model is the policy itself, and has no episodes";
        Self { option, formats: "datasets", reason }
    }
}

impl Explain for OtherFormat {
    fn report(&self) -> Option<Report> {
        Some(Report::plain(Status::Usage))
    }
}

/// A setting is given by two `--set` of a sweep.
#[derive(Debug, thiserror::Error)]
#[error("`{key}` is given by more than one --set")]
pub(crate) struct RepeatedKey {
    pub(crate) key: String,
}

impl Explain for RepeatedKey {
    fn report(&self) -> Option<Report> {
        let hint = format!("give all of its values in one, as in `--set {}=1,2`", self.key);
        Some(Report::new(Status::Usage, hint))
    }
}

/// Two combinations of a sweep are the same run.
#[derive(Debug, thiserror::Error)]
#[error("two combinations have the same settings: `{first}` and `{second}`")]
pub(crate) struct SameRun {
    pub(crate) first: String,
    pub(crate) second: String,
}

impl Explain for SameRun {
    fn report(&self) -> Option<Report> {
        Some(Report::new(Status::Usage, "give every value and every seed once"))
    }
}

/// A folder holds files of two runs.
#[derive(Debug, thiserror::Error)]
#[error(
    "`{}` holds files of two runs: its policy is of run {policy}, and `{file}` of run {other}",
    folder.display()
)]
pub(crate) struct OtherRun {
    pub(crate) folder: PathBuf,
    pub(crate) policy: RunId,
    pub(crate) file: &'static str,
    pub(crate) other: RunId,
}

impl Explain for OtherRun {
    fn report(&self) -> Option<Report> {
        let hint = "give the policy file itself, if it is the one that is meant; `rher train \
                    --resume DIR` writes the policy of the checkpoint again";
        Some(Report::new(Status::Damaged, hint))
    }
}

/// A recording does not reproduce.
#[derive(Debug, thiserror::Error)]
#[error(
    "`{}` does not reproduce: in episode {}, step {}, `{}` is {} in the recording, but {} when \
     the episode is simulated again",
    path.display(),
    difference.episode,
    difference.step,
    difference.field,
    difference.recorded,
    difference.simulated
)]
pub(crate) struct NotReal {
    pub(crate) path: PathBuf,
    pub(crate) difference: Difference,
    /// The program and the physics that made the recording, where their versions differ from ours.
    pub(crate) made_by: Option<String>,
}

impl Explain for NotReal {
    fn report(&self) -> Option<Report> {
        let hint = match &self.made_by {
            Some(made_by) => format!(
                "it was recorded by {made_by}, whose physics may differ: verify it with that version"
            ),
            None => "the recording was changed, or it was made by a changed program".to_owned(),
        };
        Some(Report::new(Status::NotReal, hint))
    }
}
