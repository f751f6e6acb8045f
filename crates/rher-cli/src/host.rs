//! What the operating system gives: threads, signals that ask the program to end, and how it is started again.

use crate::exit_code::Status;
use anyhow::Context as _;
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::thread;
use std::time::Duration;

#[cfg_attr(unix, path = "host/unix.rs")]
#[cfg_attr(not(unix), path = "host/other.rs")]
mod system;

pub(crate) use system::{
    SIGHUP, SIGINT, SIGTERM, SIGUSR1, end_with_parent, on_signals, own_group, pass_on, signal_of,
};

/// How long a program that was asked to end by another signal than Ctrl-C may take: whoever sends
/// them kills it soon after.
const GRACE: Duration = Duration::from_secs(4);

/// As many threads as were asked for, or as there are cores.
pub(crate) fn threads(asked: Option<NonZeroUsize>) -> usize {
    let cores = || thread::available_parallelism().map_or(1, NonZeroUsize::get);
    asked.map_or_else(cores, NonZeroUsize::get)
}

/// How to start a process of this program.
#[derive(Clone, Debug)]
pub(crate) struct Again {
    file: PathBuf,
    arguments: Vec<OsString>,
}

impl Again {
    /// The file that is running; on Linux also if another one has taken its place.
    pub(crate) fn this_file() -> Self {
        let file = if cfg!(target_os = "linux") {
            "/proc/self/exe".into()
        } else {
            // Without it the system looks for the program where it looks for all of them.
            std::env::current_exe().unwrap_or_else(|_| "rher".into())
        };
        Self::new(file, Vec::new())
    }

    /// A file, and the arguments that make it this program.
    pub(crate) const fn new(file: PathBuf, arguments: Vec<OsString>) -> Self {
        Self { file, arguments }
    }

    /// What interprets the program, if something does.
    pub(crate) fn interpreter(&self) -> Option<&Path> {
        (!self.arguments.is_empty()).then_some(&*self.file)
    }

    /// The program, still without arguments of its own.
    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new(&self.file);
        command.args(&self.arguments);
        command
    }
}

/// Whether the program was asked to end, and by which signal.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stop {
    is_asked: Arc<AtomicBool>,
    signal: Arc<AtomicI32>,
}

impl Stop {
    /// Listens to signals. At the first one `announce` gets `line`, which says what is done now; a
    /// Ctrl-C after another signal ends the program at once. Other signals may come twice, from who
    /// started the program and from who ends everything on the machine.
    pub(crate) fn listen(
        announce: impl Fn(&str) + Send + 'static,
        line: &'static str,
    ) -> anyhow::Result<Self> {
        let stop = Self::default();
        let Self { is_asked, signal: first } = stop.clone();
        on_signals(move |signal| {
            let status = Status::of_signal(signal) as i32;
            if is_asked.load(Ordering::Relaxed) {
                if signal == SIGINT {
                    std::process::exit(status);
                }
                return;
            }
            first.store(signal, Ordering::Relaxed);
            is_asked.store(true, Ordering::Relaxed);
            announce(line);
            if signal != SIGINT {
                thread::spawn(move || {
                    thread::sleep(GRACE);
                    std::process::exit(status);
                });
            }
        })?;
        Ok(stop)
    }

    /// Ends the program like a signal when `time` is over.
    pub(crate) fn after(&self, time: Duration) -> anyhow::Result<()> {
        let is_asked = Arc::clone(&self.is_asked);
        let wait = move || {
            thread::sleep(time);
            is_asked.store(true, Ordering::Relaxed);
        };
        let timer = thread::Builder::new().name("timer".to_owned());
        timer.spawn(wait).context("cannot start a thread")?;
        Ok(())
    }

    /// Set when the program should end.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.is_asked
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.is_asked.load(Ordering::Relaxed)
    }

    /// The exit status of a program that ended because it was asked to.
    pub(crate) fn status(&self) -> Status {
        match self.signal.load(Ordering::Relaxed) {
            0 => Status::TimeSpent,
            signal => Status::of_signal(signal),
        }
    }
}
