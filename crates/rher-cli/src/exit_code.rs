//! What the exit status of `rher` means: a promise to scripts.

use crate::host::{SIGHUP, SIGTERM, SIGUSR1, signal_of};
use std::fmt::Write as _;
use std::process::ExitStatus;

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
    /// A file of a run, or a policy file, is damaged.
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
    /// The run folder was moved, deleted or replaced.
    FolderGone = 14,
    /// Another worker trains the cell of a plan.
    Busy = 15,
    /// The time of `--max-wall` is over; the run is saved.
    TimeSpent = 16,
    /// Ended by SIGHUP, after saving.
    HungUp = 129,
    /// Ended by SIGINT, after saving.
    Interrupted = 130,
    /// Ended by SIGTERM or SIGUSR1, after saving.
    Terminated = 143,
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
        Self::FolderGone,
        Self::Busy,
        Self::TimeSpent,
        Self::HungUp,
        Self::Interrupted,
        Self::Terminated,
    ];

    const fn meaning(self) -> &'static str {
        match self {
            Self::Success => "success",
            Self::Failure => "another error",
            Self::Usage => "the command line is wrong: an unknown task or option, or a bad value",
            Self::ConfigFile => "a settings file cannot be read, or has a wrong setting",
            Self::ConfigVersion => "a settings file or a plan has another version",
            Self::RunFolder => "the run folder is in use, already holds a run, or holds none",
            Self::Unwritable => "a file or folder cannot be written",
            Self::DiskFull => "the disk is full",
            Self::Damaged => "a file of a run, a policy file or a plan is damaged",
            Self::Environment => "the environment failed",
            Self::NotFinite => "NaN or infinity in an environment, a policy or the learner",
            Self::Recording => "a file is not a recording, or it is cut off or damaged",
            Self::NotReal => "a recorded episode does not reproduce",
            #[cfg(feature = "live")]
            Self::Address => "the program cannot listen on an address",
            Self::FolderGone => "the run folder was moved, deleted or replaced during the run",
            Self::Busy => "another worker trains the cell of the plan",
            Self::TimeSpent => "the time of --max-wall is over; the run is saved",
            Self::HungUp => "ended by SIGHUP; the run or the recording is saved",
            Self::Interrupted => "interrupted by Ctrl-C; the run or the recording is saved",
            Self::Terminated => "ended by SIGTERM or SIGUSR1; the run or the recording is saved",
        }
    }

    /// The status of a program that this signal ended.
    pub(crate) const fn of_signal(signal: i32) -> Self {
        match signal {
            SIGHUP => Self::HungUp,
            SIGTERM | SIGUSR1 => Self::Terminated,
            _ => Self::Interrupted,
        }
    }

    /// The status of a process that a signal ended, by itself or after saving.
    pub(crate) fn of_interrupted(status: ExitStatus) -> Option<Self> {
        const AFTER_SAVING: [Status; 3] = [Status::HungUp, Status::Interrupted, Status::Terminated];
        let same = |known: &Self| status.code() == Some(*known as i32);
        let killed = || signal_of(status).map(Self::of_signal);
        AFTER_SAVING.into_iter().find(same).or_else(killed)
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
