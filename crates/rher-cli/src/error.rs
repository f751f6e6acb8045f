//! What went wrong, told once: with an exit status, and with a way out where there is one.

use crate::commands::{NoDatasetId, NotReal};
use crate::exit_code::Status;
use crate::printer::StdoutError;
use crate::runs::RunError;
use rher_core::episode::RolloutError;
use rher_core::evaluate::EvaluateError;
use rher_core::event::ObserverError;
use rher_core::files::{Access, FileError};
use rher_core::policy::PolicyError;
use rher_core::train::TrainError;
use rher_core::train::checkpoint::CheckpointError;
use rher_record::export::ExportError;
use rher_record::{PlayError, ReadError};
use rher_runs::settings::{Origin, SettingsError, Source};
use rher_runs::{MetricsError, RunDirError};
use std::error::Error;
use std::io;

/// A run or a policy is of a task that is not part of this program.
#[derive(Debug, thiserror::Error)]
#[error("it was made for task `{name}`, which is not part of this program")]
pub(crate) struct ForeignTask {
    pub(crate) name: String,
}

/// How an error is told.
#[derive(Debug, PartialEq)]
pub(crate) struct Report {
    pub(crate) status: Status,
    pub(crate) hint: Option<String>,
}

impl Report {
    /// The report of whatever a command returned.
    pub(crate) fn of(error: &anyhow::Error) -> Self {
        let report = error.chain().find_map(Self::of_cause);
        report.unwrap_or(Self { status: Status::Failure, hint: None })
    }

    fn of_cause(cause: &(dyn Error + 'static)) -> Option<Self> {
        let foreign = |_: &ForeignTask| {
            Self::new(Status::Usage, "`rher tasks` lists the tasks of this program")
        };
        None.or_else(|| cause.downcast_ref().map(Self::of_settings))
            .or_else(|| cause.downcast_ref().map(Self::of_run_dir))
            .or_else(|| cause.downcast_ref().and_then(Self::of_train))
            .or_else(|| cause.downcast_ref().and_then(Self::of_checkpoint))
            .or_else(|| cause.downcast_ref().and_then(Self::of_policy))
            .or_else(|| cause.downcast_ref().and_then(Self::of_evaluate))
            .or_else(|| cause.downcast_ref().and_then(Self::of_metrics))
            .or_else(|| cause.downcast_ref().map(Self::of_run))
            .or_else(|| cause.downcast_ref().and_then(Self::of_recording))
            .or_else(|| cause.downcast_ref().map(Self::of_play))
            .or_else(|| cause.downcast_ref().map(Self::of_not_real))
            .or_else(|| cause.downcast_ref().map(Self::of_export))
            .or_else(|| {
                let usage = |_: &NoDatasetId| Self { status: Status::Usage, hint: None };
                cause.downcast_ref().map(usage)
            })
            .or_else(|| cause.downcast_ref().map(foreign))
            .or_else(|| Self::of_live(cause))
            .or_else(|| cause.downcast_ref().map(|StdoutError(error)| Self::of_write(error)))
            .or_else(|| cause.downcast_ref().and_then(Self::of_file))
    }

    fn new(status: Status, hint: impl Into<String>) -> Self {
        Self { status, hint: Some(hint.into()) }
    }

    fn of_settings(error: &SettingsError) -> Self {
        const EVERY: &str = "`rher config <TASK>` prints every setting with its value";
        let status = |origin: &Origin| match origin.source {
            Source::File(_) => Status::ConfigFile,
            Source::Recipe(_) | Source::Set | Source::Option(_) => Status::Usage,
        };
        match error {
            SettingsError::Read { .. } => {
                Self::new(Status::ConfigFile, "`rher config <TASK> > run.toml` makes one")
            }
            SettingsError::Syntax { .. } => {
                Self::new(Status::ConfigFile, "`rher config <TASK>` prints a file to start from")
            }
            SettingsError::Version { .. } => Self::new(
                Status::ConfigVersion,
                "make a new file with `rher config <TASK>`, and carry your changes over",
            ),
            SettingsError::OtherTask { found, .. } => {
                Self::new(Status::ConfigFile, format!("`rher train {found}`, or delete that line"))
            }
            SettingsError::OtherPreset { .. } => {
                Self::new(Status::ConfigFile, "leave --preset out, or delete that line")
            }
            SettingsError::Fixed { key } => {
                let hint = match key.as_str() {
                    "preset" => "use --preset",
                    "task" | "task.name" => "name the task itself: `rher train push`",
                    _ => "it is the version of this program's format",
                };
                Self::new(Status::Usage, hint)
            }
            SettingsError::Unknown { origin, nearest: Some(nearest), .. } => {
                Self::new(status(origin), format!("did you mean `{nearest}`? {EVERY}"))
            }
            SettingsError::Unknown { origin, nearest: None, .. }
            | SettingsError::Section { origin, .. }
            | SettingsError::Mistyped { origin, .. }
            | SettingsError::OtherTasksOption { origin, .. }
            | SettingsError::OutOfRange { origin, .. }
            | SettingsError::Option { origin, .. } => Self::new(status(origin), EVERY),
            SettingsError::Combination(_) | SettingsError::Unfit(_) => {
                Self::new(Status::Usage, EVERY)
            }
            SettingsError::Unwritten(_) => Self { status: Status::Failure, hint: None },
        }
    }

    fn of_run_dir(error: &RunDirError) -> Self {
        let hint = match error {
            RunDirError::InUse { .. } => {
                "wait until it is done, or choose another folder with --out".to_owned()
            }
            RunDirError::Exists { path } => format!(
                "`rher train --resume {}` goes on with it, `--out DIR` starts elsewhere",
                path.display()
            ),
            RunDirError::NoRun { .. } => "`rher train <TASK> --out DIR` starts one".to_owned(),
            RunDirError::File(error) => return Self::of_write(&error.source),
            RunDirError::Settings(error) => return Self::of_settings(error),
        };
        Self::new(Status::RunFolder, hint)
    }

    fn of_train(error: &TrainError) -> Option<Self> {
        match error {
            TrainError::Checkpoint(error) => Self::of_checkpoint(error),
            TrainError::Rollout { source, .. } => Some(Self::of_rollout(source)),
            TrainError::Evaluate { source, .. } => Self::of_evaluate(source),
            TrainError::NotFinite { .. } => Some(Self::new(
                Status::NotFinite,
                "the state before it is saved; smaller `agent.actor_learning_rate` and \
                 `agent.critic_learning_rate` help against divergence",
            )),
            TrainError::Config(_) | TrainError::Engine(_) => {
                Some(Self { status: Status::Usage, hint: None })
            }
            TrainError::Observer(ObserverError(error)) => {
                let of_file = error.downcast_ref().and_then(Self::of_file);
                of_file.or_else(|| error.downcast_ref().map(Self::of_play))
            }
            _ => None,
        }
    }

    fn of_evaluate(error: &EvaluateError) -> Option<Self> {
        match error {
            EvaluateError::Rollout(error) => Some(Self::of_rollout(error)),
            _ => None,
        }
    }

    fn of_rollout(error: &RolloutError) -> Self {
        match error {
            RolloutError::NotFinite { .. } => Self::new(
                Status::NotFinite,
                "the environment is at fault, not the learner; the seed above repeats its episode",
            ),
            RolloutError::Act { .. } => Self { status: Status::NotFinite, hint: None },
            _ => Self { status: Status::Environment, hint: None },
        }
    }

    fn of_checkpoint(error: &CheckpointError) -> Option<Self> {
        match error {
            CheckpointError::Damaged { path, .. } => {
                let hint = if path.extension().is_some_and(|extension| extension == "ckpt") {
                    "nothing was changed; an earlier checkpoint that is renamed to `current.ckpt` \
                     can be resumed, and the policy file still works"
                } else {
                    "nothing was changed; the policy file still works"
                };
                Some(Self::new(Status::Damaged, hint))
            }
            CheckpointError::Version { .. } => Some(Self::new(
                Status::Damaged,
                "resume it with the version of `rher` that made it; its policy still works",
            )),
            CheckpointError::Missing { .. } => {
                Some(Self::new(Status::RunFolder, "`rher train <TASK> --out DIR` starts a run"))
            }
            CheckpointError::Policy(error) => Self::of_policy(error),
            CheckpointError::Mismatch { .. } => Some(Self { status: Status::Damaged, hint: None }),
            CheckpointError::File(error) => Self::of_file(error),
            _ => None,
        }
    }

    fn of_policy(error: &PolicyError) -> Option<Self> {
        match error {
            PolicyError::Malformed { .. } => Some(Self::new(
                Status::Damaged,
                "a policy file is the `policy.safetensors` of a run folder",
            )),
            PolicyError::File(FileError { access: Access::Read, source, .. })
                if source.kind() == io::ErrorKind::NotFound =>
            {
                Some(Self::new(
                    Status::RunFolder,
                    "name a run folder with a policy, or a policy file",
                ))
            }
            PolicyError::File(error) => Self::of_file(error),
            _ => None,
        }
    }

    fn of_metrics(error: &MetricsError) -> Option<Self> {
        match error {
            MetricsError::TooShort { .. } => Some(Self::new(
                Status::Damaged,
                "bring the file back, or start a new run with --out",
            )),
            MetricsError::File(error) => Self::of_file(error),
        }
    }

    fn of_run(error: &RunError) -> Self {
        match error {
            RunError::Missing { .. } => Self::new(
                Status::RunFolder,
                "name the folder that `rher train` made: it has `config.toml` and `metrics.jsonl`",
            ),
            RunError::NoMetrics { .. } => {
                Self::new(Status::RunFolder, "wait for its first evaluation, or leave this run out")
            }
            RunError::Metrics { .. } | RunError::Settings { .. } => {
                Self::new(Status::Damaged, "bring the file back, or leave this run out")
            }
            RunError::Read { .. } => {
                Self::new(Status::RunFolder, "check that the file can be read")
            }
        }
    }

    fn of_recording(error: &ReadError) -> Option<Self> {
        const MADE: &str = "`rher play RUN --mcap FILE` makes a recording";
        let hint = match error {
            ReadError::File(FileError { source, .. })
                if source.kind() == io::ErrorKind::NotFound =>
            {
                MADE.into()
            }
            ReadError::File(_) => return None,
            ReadError::NotMcap { .. } | ReadError::Foreign { .. } => MADE.into(),
            ReadError::CutOff { path, whole: 0 } => {
                format!("nothing in `{}` can be saved; record it again", path.display())
            }
            ReadError::CutOff { path, .. } => format!(
                "as `{}` its whole episodes can be read; copy the file again if it was complete",
                path.with_extension("part.mcap").display()
            ),
            ReadError::Info { .. } => "read it with the version of `rher` that made it".into(),
            ReadError::Damaged { .. } | ReadError::Empty { .. } => "record it again".into(),
        };
        Some(Self::new(Status::Recording, hint))
    }

    fn of_play(error: &PlayError) -> Self {
        match error {
            PlayError::Rollout(error) => Self::of_rollout(error),
            PlayError::Misfit { .. } => Self::new(
                Status::Recording,
                "the recording is of another task than it says, or of another version of it",
            ),
        }
    }

    fn of_export(error: &ExportError) -> Self {
        match error {
            ExportError::Exists { .. } => {
                Self::new(Status::Unwritable, "choose another folder with --out, or take it away")
            }
            ExportError::File(error) => Self::of_write(&error.source),
            ExportError::Table { .. } | ExportError::Empty { .. } => {
                Self { status: Status::Failure, hint: None }
            }
            ExportError::Widths { .. } => Self::new(
                Status::Recording,
                "the recording was put together from recordings of different tasks",
            ),
        }
    }

    #[cfg(feature = "live")]
    fn of_live(cause: &(dyn Error + 'static)) -> Option<Self> {
        cause.downcast_ref().map(|_: &rher_record::LiveError| {
            Self::new(Status::Address, "`--live=127.0.0.1:0` takes any port that is free")
        })
    }

    #[cfg(not(feature = "live"))]
    fn of_live(_: &(dyn Error + 'static)) -> Option<Self> {
        None
    }

    fn of_not_real(error: &NotReal) -> Self {
        let hint = error.made_by.as_ref().map(|made_by| {
            format!("it was made by {made_by}, whose physics may differ: verify it with that")
        });
        let hint = hint.unwrap_or_else(|| "someone changed the recording, or the program".into());
        Self::new(Status::NotReal, hint)
    }

    fn of_file(FileError { access, source, .. }: &FileError) -> Option<Self> {
        match access {
            Access::Read => None,
            Access::Write => Some(Self::of_write(source)),
        }
    }

    fn of_write(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::new(
                Status::DiskFull,
                "make room, and repeat the command; a run that had begun continues from its last \
                 checkpoint with `rher train --resume DIR`",
            ),
            _ => Self::new(Status::Unwritable, "choose a place that you may write in"),
        }
    }
}
