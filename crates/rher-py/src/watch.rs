//! Those who watch a run that Python started: the files of its folder, and Python itself.

use crate::any_recorder::AnyRecorder;
use crate::calls::Calls;
use crate::error::{InternalError, told};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rher_core::event::{Event, Observer, ObserverError, Progress};
use rher_core::files::FileError;
use rher_record::RecorderError;
use rher_runs::{EventFile, RunFiles};
use std::ffi::CString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

/// How often Python may handle signals during a run.
const SIGNALS: Duration = Duration::from_millis(50);

/// What Python hears of.
pub(crate) enum Told {
    Event(Event),
    Warning(String),
}

/// Files that are written beside the metrics.
pub(crate) struct Beside {
    pub(crate) recorder: Option<Box<dyn AnyRecorder>>,
    /// For `TensorBoard`.
    pub(crate) events: Option<EventFile>,
}

/// Writes down what happens, and tells Python of it.
pub(crate) struct Watch<'a> {
    pub(crate) files: &'a mut RunFiles,
    pub(crate) beside: Beside,
    pub(crate) tell: Sender<Told>,
}

impl Watch<'_> {
    /// Gives the recording its name.
    pub(crate) fn finish(&mut self) {
        let Some(recorder) = self.beside.recorder.take() else { return };
        if let Err(error) = recorder.finish() {
            self.warn(format!(
                "the recording is not finished: {}; its whole episodes can still be read",
                told(&error)
            ));
        }
    }

    fn warn(&self, text: String) {
        // Nobody listens only where Python has gone.
        let _ = self.tell.send(Told::Warning(text));
    }

    /// Training is worth more than its recording.
    fn go_without_recording(&mut self, error: &FileError) {
        let kept = self.beside.recorder.take().and_then(AnyRecorder::stop);
        let kept = kept.map(|path| format!("; the episodes before are in `{}`", path.display()));
        self.warn(format!(
            "recording has stopped, training continues: {}{}",
            told(error),
            kept.unwrap_or_default()
        ));
    }
}

impl Observer for Watch<'_> {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        match event {
            Event::Evaluated(line) => {
                self.files.on(event)?;
                if let Some(events) = &mut self.beside.events
                    && let Err(error) = events.append(line)
                {
                    self.beside.events = None;
                    self.warn(format!(
                        "event files have stopped, training continues: {}",
                        told(&error)
                    ));
                }
            }
            // Python hears of what is saved, not of what is about to be.
            Event::Saving => return self.files.on(event),
            Event::Explored(script) => {
                if let Some(recorder) = &mut self.beside.recorder
                    && recorder.wants(script.number)
                {
                    match recorder.record(script) {
                        Ok(()) => {}
                        Err(RecorderError::Play(error)) => return Err(ObserverError(error.into())),
                        Err(RecorderError::Write(error)) => self.go_without_recording(&error),
                    }
                }
                return Ok(());
            }
            _ => {}
        }
        let _ = self.tell.send(Told::Event(event.clone()));
        Ok(())
    }

    fn wants(&self, episode: u64) -> bool {
        self.beside.recorder.as_ref().is_some_and(|recorder| recorder.wants(episode))
    }
}

/// Tells Python of events, and lets it handle signals, until the run is over. An exception of
/// either interrupts the run, and its `end` stops it after an episode.
pub(crate) fn watch(
    heard: &Receiver<Told>,
    stop: &AtomicBool,
    calls: &Calls,
    end: Option<Instant>,
    on_event: Option<&Py<PyAny>>,
) -> PyResult<()> {
    let mut watched = Ok(());
    loop {
        let heard = match heard.recv_timeout(SIGNALS) {
            Ok(heard) => Some(heard),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return watched,
        };
        if end.is_some_and(|end| Instant::now() >= end) {
            stop.store(true, Ordering::Relaxed);
        }
        let handled = Python::attach(|py| {
            py.check_signals()?;
            match (heard, on_event, &watched) {
                (Some(Told::Event(event)), Some(on_event), Ok(())) => {
                    on_event.call1(py, (as_dict(py, &event)?,)).map(drop)
                }
                (Some(Told::Warning(text)), _, _) => {
                    let text = CString::new(text).unwrap_or_default();
                    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 3)
                }
                _ => Ok(()),
            }
        });
        if let Err(error) = handled {
            calls.interrupt();
            stop.store(true, Ordering::Relaxed);
            watched = Err(error);
        }
    }
}

/// An event as a Python dictionary.
fn as_dict<'py>(py: Python<'py>, event: &Event) -> PyResult<Bound<'py, PyDict>> {
    let (kind, dict) = match event {
        Event::Progress(Progress { env_steps, episodes, updates }) => {
            let dict = PyDict::new(py);
            dict.set_item("env_steps", env_steps)?;
            dict.set_item("episodes", episodes)?;
            dict.set_item("updates", updates)?;
            ("progress", dict)
        }
        Event::Evaluated(metrics) => {
            let json = serde_json::to_string(metrics);
            let json = json.map_err(|error| InternalError::new_err(told(&error)))?;
            let dict = py.import("json")?.call_method1("loads", (json,))?;
            ("evaluated", dict.cast_into::<PyDict>()?)
        }
        Event::Saved => ("saved", PyDict::new(py)),
        _ => ("other", PyDict::new(py)),
    };
    dict.set_item("kind", kind)?;
    Ok(dict)
}
