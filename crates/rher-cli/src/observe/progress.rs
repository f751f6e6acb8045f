//! How far a run is: a bar where stderr is a terminal, and a line for every evaluation.

use crate::numbers::{duration, percent, thousands};
use crate::printer::{Printer, Verbosity};
use indicatif::{ProgressBar, ProgressStyle};
use rher_core::config::TrainConfig;
use rher_core::event::{Metrics, Progress};
use std::io::{self, IsTerminal as _};
use std::time::Instant;

const TEMPLATE: &str = "{wide_bar} {percent:>3} %\n{wide_msg}";

/// Shows how far a run is.
pub(crate) struct ProgressView {
    printer: Printer,
    /// `None` where nobody would see it.
    bar: Option<ProgressBar>,
    env_steps: u64,
    started: Instant,
    started_at: u64,
    results: String,
}

impl ProgressView {
    /// A view of a run with these settings that is at `now`.
    pub(crate) fn new(printer: Printer, config: &TrainConfig, now: Progress) -> Self {
        let env_steps = config.env_steps;
        let shown = printer.verbosity() == Verbosity::Normal && io::stderr().is_terminal();
        let bar = shown.then(|| {
            let style = ProgressStyle::with_template(TEMPLATE);
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(env_steps).with_style(style).with_position(now.env_steps)
        });
        Self {
            printer,
            bar,
            env_steps,
            started: Instant::now(),
            started_at: now.env_steps,
            results: "not evaluated yet".to_owned(),
        }
    }

    /// Training went on.
    pub(crate) fn advance(&self, now: Progress) {
        if let Some(bar) = &self.bar {
            bar.set_position(now.env_steps);
            bar.set_message(self.line(now.env_steps));
        }
    }

    /// An evaluation ended.
    pub(crate) fn evaluated(&mut self, metrics: &Metrics) {
        let rates: Vec<String> = metrics
            .success
            .iter()
            .map(|rate| rate.map_or("–".to_owned(), |rate| percent(f64::from(rate))))
            .collect();
        self.results = format!("guide {}  success {}", metrics.guide, rates.join(" · "));
        let line = self.line(metrics.env_steps);
        match &self.bar {
            Some(bar) => bar.set_message(line),
            None => self.printer.note(line),
        }
    }

    /// Something that can tell the user a line while the bar is there, from any thread.
    pub(crate) fn teller(&self) -> impl Fn(&str) + Send + 'static {
        let (printer, bar) = (self.printer, self.bar.clone());
        move |line| match &bar {
            Some(bar) => bar.suspend(|| printer.note(line)),
            None => printer.note(line),
        }
    }

    /// Prints a warning.
    pub(crate) fn warn(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| self.printer.warn(text)),
            None => self.printer.warn(text),
        }
    }

    /// Takes the bar away, so that other text can follow.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn line(&self, env_steps: u64) -> String {
        let seconds = self.started.elapsed().as_secs_f64();
        let rate = (env_steps - self.started_at) as f64 / seconds.max(f64::EPSILON);
        let left = self.env_steps.saturating_sub(env_steps) as f64 / rate.max(f64::EPSILON);
        format!(
            "{} of {} steps  {} steps/s  ETA {}  {}",
            thousands(env_steps),
            thousands(self.env_steps),
            thousands(rate as u64),
            duration(left),
            self.results,
        )
    }
}
