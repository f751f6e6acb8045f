//! Ctrl-C and processes where there are no other signals, which is on Windows.

use anyhow::Context as _;
pub(crate) use signal_hook::consts::{SIGINT, SIGTERM};
use std::process::{Command, ExitStatus};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Numbers of signals that are never sent here; they are those of Linux.
pub(crate) const SIGHUP: i32 = 1;
pub(crate) const SIGUSR1: i32 = 10;

/// How often the program looks whether Ctrl-C was pressed.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Whether the process `parent` still runs, which nothing says here.
pub(crate) const fn end_with_parent(_: u32) -> bool {
    true
}

/// Calls `act` in a thread of its own for every Ctrl-C.
pub(crate) fn on_signals(mut act: impl FnMut(i32) + Send + 'static) -> anyhow::Result<()> {
    const CANNOT: &str = "cannot listen to Ctrl-C";
    let pressed = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(SIGINT, Arc::clone(&pressed)).context(CANNOT)?;
    let listen = move || {
        loop {
            thread::sleep(LOOK_EVERY);
            if pressed.swap(false, Ordering::Relaxed) {
                act(SIGINT);
            }
        }
    };
    thread::Builder::new().name("signals".to_owned()).spawn(listen).context(CANNOT)?;
    Ok(())
}

/// Does nothing: Ctrl-C reaches every process of a console.
pub(crate) const fn own_group(_: &mut Command) {}

/// Does nothing, for the same reason.
pub(crate) const fn pass_on(_: i32, _: u32) {}

/// The signal that ended a process: none does here.
pub(crate) const fn signal_of(_: ExitStatus) -> Option<i32> {
    None
}
