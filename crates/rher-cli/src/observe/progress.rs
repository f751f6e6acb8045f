//! How far a run is: a line for every evaluation, and a bar below it where stderr is a terminal.

use super::course::Course;
use crate::numbers::thousands;
use crate::printer::{Printer, Verbosity};
use indicatif::{ProgressBar, ProgressStyle};
use rher_core::event::{Metrics, Progress};
use rher_runs::Evaluation;
use std::io::{self, IsTerminal as _};
use std::time::Instant;

const TEMPLATE: &str = "{prefix}{wide_bar}\n{wide_msg}";

/// Shows how far a run is.
pub(crate) struct ProgressView {
    printer: Printer,
    /// `None` where nobody would see it.
    bar: Option<ProgressBar>,
    course: Course,
    /// Since when, and from which step on, the speed is measured: the evaluation before the latest.
    since: [(Instant, u64); 2],
}

impl ProgressView {
    /// A view of a run that is at `now`, after these evaluations.
    pub(crate) fn new(
        printer: Printer,
        mut course: Course,
        now: Progress,
        evaluations: &[Evaluation],
    ) -> Self {
        let shown = printer.verbosity() == Verbosity::Normal && io::stderr().is_terminal();
        if let Some(usually) = course.usually() {
            printer.note(usually);
        }
        for Evaluation { env_steps, success, success_final, .. } in evaluations {
            course.evaluated(*env_steps, success, *success_final);
        }
        if let Some(Evaluation { success, .. }) = evaluations.last() {
            let (steps, rates) = (thousands(now.env_steps), course.rates(success));
            printer.note(format_args!("resumed at {steps} steps: {rates}"));
        }
        let bar = shown.then(|| {
            let style = ProgressStyle::with_template(TEMPLATE);
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(course.end(now.env_steps)).with_style(style);
            bar.with_prefix(prefix(&course)).with_position(now.env_steps)
        });
        let since = (Instant::now(), now.env_steps);
        Self { printer, bar, course, since: [since; 2] }
    }

    /// Training went on.
    pub(crate) fn advance(&self, now: Progress) {
        let Some(bar) = &self.bar else { return };
        let (steps, speed) = (now.env_steps, self.speed(now.env_steps));
        bar.set_length(self.course.end(steps));
        bar.set_position(steps);
        bar.set_message(format!(
            "{} steps  {} steps/s  {}",
            thousands(steps),
            thousands(speed as u64),
            self.course.left(steps, speed),
        ));
    }

    /// An evaluation ended.
    pub(crate) fn evaluated(&mut self, metrics: &Metrics) {
        let Metrics { env_steps, guide, success, success_final, .. } = metrics;
        let success: Vec<_> = success.iter().map(|rate| rate.map(f64::from)).collect();
        self.course.evaluated(*env_steps, &success, f64::from(*success_final));
        let speed = self.speed(*env_steps);
        let line = format!(
            "{:>9} steps  {}  guide {guide}  {} steps/s  {}",
            thousands(*env_steps),
            self.course.rates(&success),
            thousands(speed as u64),
            self.course.left(*env_steps, speed),
        );
        self.since = [self.since[1], (Instant::now(), *env_steps)];
        match &self.bar {
            Some(bar) => {
                bar.set_prefix(prefix(&self.course));
                bar.suspend(|| self.printer.note(line));
            }
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

    /// Steps in a second.
    fn speed(&self, env_steps: u64) -> f64 {
        let [(since, from), _] = self.since;
        let steps = env_steps.saturating_sub(from) as f64;
        (steps / since.elapsed().as_secs_f64().max(f64::EPSILON)).max(f64::EPSILON)
    }
}

/// What stands before the bar: success so far.
fn prefix(course: &Course) -> String {
    let picture = course.picture();
    if picture.is_empty() { picture } else { picture + "  " }
}
