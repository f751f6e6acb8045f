//! How far a run is: a bar where stderr is a terminal, and a line for every evaluation.

use crate::printer::{Printer, Verbosity};
use indicatif::{ProgressBar, ProgressStyle};
use rher_core::config::TrainConfig;
use rher_core::event::{Metrics, Progress};
use std::io::{self, IsTerminal as _};
use std::time::{Duration, Instant};

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

/// `1234567` as `1,234,567`.
pub(crate) fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&[u8]> = digits.as_bytes().rchunks(3).rev().collect();
    String::from_utf8_lossy(&groups.join(&b',')).into_owned()
}

/// A share as `95 %`.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// Seconds as `42 s`, `3 min 05 s` or `2 h 07 min`.
pub(crate) fn duration(seconds: f64) -> String {
    let seconds = Duration::try_from_secs_f64(seconds).map_or(u64::MAX, |time| time.as_secs());
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{} h {:02} min", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!([0, 999, 1_000, 1_234_567].map(thousands), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([0.4, 65.0, 7_620.0].map(duration), ["0 s", "1 min 05 s", "2 h 07 min"]);
        assert_eq!(percent(0.954), "95 %");
    }
}
