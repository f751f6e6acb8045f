//! Processes that this one starts: they get its signals, and none is started after one.

use crate::host::{on_signals, own_group, pass_on};
use std::io;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The processes that are running, shared by the threads that wait for them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Children(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    /// Their numbers.
    running: Vec<u32>,
    /// The first signal that asked this process to end.
    signal: Option<i32>,
}

impl Children {
    /// No processes yet; every signal that asks this process to end is passed on to them.
    pub(crate) fn new() -> anyhow::Result<Self> {
        let children = Self::default();
        let passing_on = children.clone();
        on_signals(move |signal| {
            let mut state = passing_on.lock();
            state.signal.get_or_insert(signal);
            state.running.iter().for_each(|&process| pass_on(signal, process));
        })?;
        Ok(children)
    }

    /// The first signal that asked this process to end.
    pub(crate) fn signal(&self) -> Option<i32> {
        self.lock().signal
    }

    /// Starts a process with `start`; none after a signal.
    ///
    /// It is in a process group of its own, so that a Ctrl-C reaches it once, from here.
    pub(crate) fn start(&self, command: &mut Command) -> io::Result<Option<Child>> {
        // The lock keeps a signal from coming between the look and the start.
        let mut state = self.lock();
        if state.signal.is_some() {
            return Ok(None);
        }
        own_group(command);
        let child = command.spawn()?;
        state.running.push(child.id());
        Ok(Some(child))
    }

    /// Waits for the end of a process.
    pub(crate) fn wait(&self, mut child: Child) -> io::Result<ExitStatus> {
        let status = child.wait();
        self.lock().running.retain(|running| *running != child.id());
        status
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
