//! Signals and processes on Linux and macOS.

use anyhow::Context as _;
use rustix::process::{Pid, Signal, getppid, kill_process};
pub(crate) use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::iterator::Signals;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::process::{Command, ExitStatus};
use std::thread;

/// Asks the system to end this process by SIGTERM when the process `parent` ends; whether `parent`
/// still runs.
pub(crate) fn end_with_parent(parent: u32) -> bool {
    // Where it fails, as in a sandbox, the parent can still pass signals on.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_parent_process_death_signal(Some(Signal::TERM));
    getppid().map(Pid::as_raw_pid).is_some_and(|pid| u32::try_from(pid) == Ok(parent))
}

/// Calls `act` in a thread of its own for every signal that asks the program to end.
///
/// A signal that is ignored stays ignored: `nohup` ignores SIGHUP, and shells ignore SIGINT for the
/// background jobs of scripts.
pub(crate) fn on_signals(mut act: impl FnMut(i32) + Send + 'static) -> anyhow::Result<()> {
    const CANNOT: &str = "cannot listen to signals";
    let ignored = ignored();
    let heard = [SIGHUP, SIGINT, SIGTERM, SIGUSR1].into_iter();
    let heard = heard.filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let mut signals = Signals::new(heard).context(CANNOT)?;
    let listen = move || signals.forever().for_each(&mut act);
    thread::Builder::new().name("signals".to_owned()).spawn(listen).context(CANNOT)?;
    Ok(())
}

/// The signals that are ignored, as Linux reports them: bit 0 is signal 1.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

/// Puts the process that `command` starts into a group of its own, which the terminal's Ctrl-C does
/// not reach.
pub(crate) fn own_group(command: &mut Command) {
    command.process_group(0);
}

/// Sends a signal to a process that [`own_group`] keeps it from. It may have ended just now.
pub(crate) fn pass_on(signal: i32, process: u32) {
    let process = Pid::from_raw(process.cast_signed());
    if let (Some(signal), Some(process)) = (Signal::from_named_raw(signal), process) {
        let _ = kill_process(process, signal);
    }
}

/// The signal that ended a process.
pub(crate) fn signal_of(status: ExitStatus) -> Option<i32> {
    status.signal()
}
