//! Settings from the command line and from files.

use super::report::{Explain, Report};
use crate::exit_code::Status;
use rher_runs::SettingsError;
use rher_runs::settings::{Origin, Source};

impl Explain for SettingsError {
    fn report(&self) -> Option<Report> {
        const EVERY: &str = "`rher config <TASK>` prints every setting with its value";
        let status = |origin: &Origin| match origin.source {
            Source::File(_) => Status::ConfigFile,
            Source::Recipe(_) | Source::Set | Source::Option(_) => Status::Usage,
        };
        Some(match self {
            Self::Read { .. } => Report::new(
                Status::ConfigFile,
                "`rher config <TASK> > run.toml` makes a settings file",
            ),
            Self::Syntax { .. } => {
                Report::new(Status::ConfigFile, "`rher config <TASK>` prints a file to start from")
            }
            Self::Version { .. } => Report::new(
                Status::ConfigVersion,
                "make a new file with `rher config <TASK>`, and carry your changes over",
            ),
            Self::OtherTask { found, .. } => Report::new(
                Status::ConfigFile,
                format!("`rher train {found}` trains it; or delete that line"),
            ),
            Self::OtherPreset { .. } => {
                Report::new(Status::ConfigFile, "leave --preset out, or delete that line")
            }
            Self::Fixed { key } => {
                let hint = match key.as_str() {
                    "preset" => "use --preset",
                    "task" | "task.name" => "give the task itself, as in `rher train push`",
                    _ => "it is the version of this program's file format",
                };
                Report::new(Status::Usage, hint)
            }
            Self::NotOfEnvironments { .. } => Report::new(
                Status::Usage,
                "a policy is judged as it is; `rher train <TASK> --set KEY=VALUE` trains with other \
                 settings",
            ),
            Self::StartedFrom { origin, .. } => Report::new(
                status(origin),
                "`rher train <TASK> --from RUN` starts from a run; leave the section `[from]` out",
            ),
            Self::Unknown { origin, nearest: Some(nearest), .. } => {
                Report::new(status(origin), format!("did you mean `{nearest}`? {EVERY}"))
            }
            Self::Unknown { origin, nearest: None, .. }
            | Self::Section { origin, .. }
            | Self::Mistyped { origin, .. }
            | Self::OtherTasksOption { origin, .. }
            | Self::OutOfRange { origin, .. }
            | Self::Option { origin, .. } => Report::new(status(origin), EVERY),
            Self::Combination(_) | Self::Unfit(_) => Report::new(Status::Usage, EVERY),
            Self::Memory(_) => Report::plain(Status::Usage),
            Self::Unwritten(_) => Report::plain(Status::Failure),
        })
    }
}
