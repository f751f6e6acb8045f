//! Those who watch a run.

mod course;
mod progress;

pub(crate) use course::Course;
pub(crate) use progress::ProgressView;

use rher_core::event::{Event, Metrics, Observer, ObserverError};
use rher_core::files::FileError;
use rher_envs::Simulated;
use rher_record::{Recorder, RecorderError};
use rher_runs::sweep::{Guard, Pulse};
use rher_runs::{EventFile, RunFiles};

/// Writes metrics down, shows progress and records episodes.
pub(crate) struct Watch<E, const N: usize> {
    pub(crate) files: RunFiles,
    /// What the cell of a plan is claimed by.
    pub(crate) claim: Option<(Guard, Pulse)>,
    /// For `TensorBoard`.
    pub(crate) events: Option<EventFile>,
    pub(crate) progress: ProgressView,
    pub(crate) recorder: Option<Recorder<E, N>>,
    #[cfg(feature = "live")]
    pub(crate) live: Option<rher_record::Live>,
    /// The last evaluation that was seen.
    pub(crate) last: Option<Metrics>,
}

impl<const N: usize, E: Simulated<N>> Watch<E, N> {
    /// Nothing is written for a cell that another process has taken over.
    fn check_claim(&self) -> Result<(), ObserverError> {
        match &self.claim {
            Some((guard, _)) => guard.check().map_err(|lost| ObserverError(lost.into())),
            None => Ok(()),
        }
    }

    /// Training is worth more than its recording.
    fn go_without_recording(&mut self, error: &FileError) {
        let kept = self.recorder.take().and_then(Recorder::stop);
        let kept = kept.map(|path| format!("; the episodes before are in `{}`", path.display()));
        let (path, source, kept) = (error.path.display(), &error.source, kept.unwrap_or_default());
        self.progress.warn(&format!(
            "recording has stopped, training continues: cannot write `{path}`: {source}{kept}"
        ));
    }
}

impl<const N: usize, E: Simulated<N>> Observer for Watch<E, N> {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        match event {
            Event::Progress(progress) => {
                self.progress.advance(*progress);
                if let Some((_, pulse)) = &self.claim {
                    pulse.report(progress.env_steps);
                }
            }
            Event::Evaluated(metrics) => {
                self.check_claim()?;
                self.files.on(event)?;
                if let Some(events) = &mut self.events
                    && let Err(error) = events.append(metrics)
                {
                    let (path, source) = (error.path.display(), &error.source);
                    self.progress.warn(&format!(
                        "event files have stopped, training continues: cannot write `{path}`: {source}"
                    ));
                    self.events = None;
                }
                self.progress.evaluated(metrics);
                #[cfg(feature = "live")]
                if let Some(live) = &self.live {
                    live.send(metrics);
                }
                self.last = Some(metrics.as_ref().clone());
            }
            Event::Saving => {
                self.check_claim()?;
                self.files.on(event)?;
            }
            Event::Explored(script) => {
                if let Some(recorder) = &mut self.recorder
                    && recorder.wants(script.number)
                {
                    match recorder.record(script) {
                        Ok(()) => {}
                        Err(RecorderError::Play(error)) => return Err(ObserverError(error.into())),
                        Err(RecorderError::Write(error)) => self.go_without_recording(&error),
                    }
                }
                #[cfg(feature = "live")]
                if let Some(live) = &self.live {
                    live.show(script);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn wants(&self, episode: u64) -> bool {
        #[cfg(feature = "live")]
        if self.live.as_ref().is_some_and(rher_record::Live::is_idle) {
            return true;
        }
        self.recorder.as_ref().is_some_and(|recorder| recorder.wants(episode))
    }
}
