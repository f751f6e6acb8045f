//! What the exit status of `rher` means: a promise to scripts.

use std::fmt::Write as _;
use std::process::ExitCode;

/// How a run of the program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Status {
    /// Everything went well.
    Success = 0,
    /// Something else went wrong.
    Failure = 1,
    /// The command line is wrong; clap ends with the same number.
    Usage = 2,
    /// A config file cannot be read, or has a setting that is unknown or out of range.
    ConfigFile = 3,
    /// A config file has another version.
    ConfigVersion = 4,
    /// The run folder is in use, already holds a run, or holds none.
    RunFolder = 5,
    /// A file or folder cannot be written.
    Unwritable = 6,
    /// The disk is full.
    DiskFull = 7,
    /// A checkpoint or a policy file is damaged.
    Damaged = 8,
    /// The environment failed.
    Environment = 9,
    /// A number became NaN or infinite.
    NotFinite = 10,
    /// A file is not a whole recording of this program.
    Recording = 11,
    /// A recording is not what happens.
    NotReal = 12,
    /// An address cannot be listened on.
    #[cfg(feature = "live")]
    Address = 13,
    /// Interrupted, after saving.
    Interrupted = 130,
}

impl Status {
    const ALL: &[Self] = &[
        Self::Success,
        Self::Failure,
        Self::Usage,
        Self::ConfigFile,
        Self::ConfigVersion,
        Self::RunFolder,
        Self::Unwritable,
        Self::DiskFull,
        Self::Damaged,
        Self::Environment,
        Self::NotFinite,
        Self::Recording,
        Self::NotReal,
        #[cfg(feature = "live")]
        Self::Address,
        Self::Interrupted,
    ];

    const fn meaning(self) -> &'static str {
        match self {
            Self::Success => "everything went well",
            Self::Failure => "something else went wrong",
            Self::Usage => "the command line is wrong: unknown task or option, bad value",
            Self::ConfigFile => "a config file is unreadable or has a wrong setting",
            Self::ConfigVersion => "a config file has another version",
            Self::RunFolder => "the run folder is in use, already holds a run, or holds none",
            Self::Unwritable => "a file or folder cannot be written",
            Self::DiskFull => "the disk is full",
            Self::Damaged => "a checkpoint or policy file is damaged",
            Self::Environment => "the environment failed",
            Self::NotFinite => "NaN or infinity in an environment or in a loss",
            Self::Recording => "a file is not a recording, or is cut off or damaged",
            Self::NotReal => "a recorded episode is not what happens when it is played again",
            #[cfg(feature = "live")]
            Self::Address => "an address cannot be listened on",
            Self::Interrupted => "interrupted by Ctrl-C; the run or the recording is saved",
        }
    }

    /// The list of all of them, as `--help` shows it.
    pub(crate) fn table() -> String {
        let mut table = String::from("Exit status:\n");
        for &status in Self::ALL {
            let _ = writeln!(table, "{:>5}  {}", status as u8, status.meaning());
        }
        table
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        Self::from(status as u8)
    }
}
