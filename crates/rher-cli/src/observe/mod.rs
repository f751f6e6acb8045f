//! Those who watch a run.

mod progress;

pub(crate) use progress::{ProgressView, duration, percent, thousands};

use rher_core::event::{Event, Metrics, Observer, ObserverError};
use rher_runs::MetricsFile;

/// Writes metrics down and shows progress.
pub(crate) struct Watch {
    pub(crate) metrics: MetricsFile,
    pub(crate) progress: ProgressView,
    /// The last evaluation that was seen.
    pub(crate) last: Option<Metrics>,
}

impl Observer for Watch {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        match event {
            Event::Progress(progress) => self.progress.advance(*progress),
            Event::Evaluated(metrics) => {
                let written = self.metrics.append(metrics);
                written.map_err(|error| ObserverError(error.into()))?;
                self.progress.evaluated(metrics);
                self.last = Some(metrics.as_ref().clone());
            }
            Event::Saved => {}
        }
        Ok(())
    }
}
