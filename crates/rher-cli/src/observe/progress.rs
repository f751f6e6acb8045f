//! How far a run is: a line for every evaluation, and a bar below it where stderr is a terminal.

use crate::expected;
use crate::numbers::{duration, percent, range_of_steps, thousands};
use crate::printer::{Printer, Verbosity};
use indicatif::{ProgressBar, ProgressStyle};
use rher_core::config::TrainConfig;
use rher_core::event::{Metrics, Progress};
use std::io::{self, IsTerminal as _};
use std::time::Instant;

const TEMPLATE: &str = "{wide_bar}\n{wide_msg}";

/// A run as those who look on know it.
pub(crate) struct Course {
    /// Names of the sub-tasks.
    pub(crate) subtasks: Vec<String>,
    /// Budget in environment steps.
    pub(crate) env_steps: u64,
    /// Steps from one evaluation to the next.
    interval: u64,
    until: f32,
    /// Steps after which such runs were solved.
    usual: Option<Vec<u64>>,
}

impl Course {
    pub(crate) fn new(config: &TrainConfig, subtasks: Vec<String>, episode_steps: usize) -> Self {
        let interval = config.evaluation.every_episodes * episode_steps as u64;
        let TrainConfig { env_steps, until, .. } = *config;
        Self { subtasks, env_steps, interval, until, usual: expected::usual(config) }
    }

    /// `reach 100 % · push 88 %`.
    fn rates(&self, success: impl IntoIterator<Item = Option<f64>>) -> String {
        let rates = self
            .subtasks
            .iter()
            .zip(success)
            .map(|(name, rate)| format!("{name} {}", rate.map_or("–".to_owned(), percent)));
        rates.collect::<Vec<_>>().join(" · ")
    }

    /// The step at which it will end, at a guess: with the budget, where nobody knows better.
    fn end(&self, now: u64, last: Option<f32>) -> u64 {
        let solved = self.until > 0.0 && last.is_some_and(|rate| rate >= self.until);
        let end = self.usual.as_ref().map(|usual| expected::end(usual, now, self.interval, solved));
        end.map_or(self.env_steps, |end| end.min(self.env_steps))
    }

    /// `about 20 s to go, at most 9 min 30 s`, with so many steps in a second.
    fn left(&self, now: u64, last: Option<f32>, speed: f64) -> String {
        let time = |steps: u64| duration(steps.saturating_sub(now) as f64 / speed);
        let most = time(self.env_steps);
        match self.usual {
            Some(_) => format!("about {} to go, at most {most}", time(self.end(now, last))),
            None if self.until > 0.0 => format!("at most {most} to go"),
            None => format!("{most} to go"),
        }
    }

    /// What is known before a run begins, if anything.
    fn usually(&self) -> Option<String> {
        let (usual, until) = (self.usual.as_ref()?, f64::from(self.until));
        if *usual.last()? > self.env_steps {
            return None;
        }
        Some(format!(
            "goal: {} in two consecutive evaluations, which usually takes {}, at most {}",
            percent(until),
            range_of_steps(usual),
            thousands(self.env_steps)
        ))
    }
}

/// Shows how far a run is.
pub(crate) struct ProgressView {
    printer: Printer,
    /// `None` where nobody would see it.
    bar: Option<ProgressBar>,
    course: Course,
    /// Success in the latest evaluation.
    last: Option<f32>,
    /// Since when, and from which step on, the speed is measured: the evaluation before the latest.
    since: [(Instant, u64); 2],
}

impl ProgressView {
    /// A view of a run that is at `now`, with the success of each sub-task in its latest evaluation.
    pub(crate) fn new(
        printer: Printer,
        course: Course,
        now: Progress,
        latest: Option<&[Option<f64>]>,
    ) -> Self {
        let shown = printer.verbosity() == Verbosity::Normal && io::stderr().is_terminal();
        if let Some(usually) = course.usually() {
            printer.note(usually);
        }
        if let Some(success) = latest {
            let (steps, rates) = (thousands(now.env_steps), course.rates(success.iter().copied()));
            printer.note(format_args!("resumed at {steps} steps: {rates}"));
        }
        let bar = shown.then(|| {
            let style = ProgressStyle::with_template(TEMPLATE);
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(course.env_steps).with_style(style).with_position(now.env_steps)
        });
        let since = (Instant::now(), now.env_steps);
        let last = latest.and_then(|success| success.last().copied().flatten());
        let last = last.map(|rate| rate as f32);
        Self { printer, bar, course, last, since: [since; 2] }
    }

    /// Training went on.
    pub(crate) fn advance(&self, now: Progress) {
        let Some(bar) = &self.bar else { return };
        let (steps, speed) = (now.env_steps, self.speed(now.env_steps));
        bar.set_length(self.course.end(steps, self.last));
        bar.set_position(steps);
        bar.set_message(format!(
            "{} steps  {} steps/s  {}",
            thousands(steps),
            thousands(speed as u64),
            self.course.left(steps, self.last, speed),
        ));
    }

    /// An evaluation ended.
    pub(crate) fn evaluated(&mut self, metrics: &Metrics) {
        self.last = Some(metrics.success_final);
        let Metrics { env_steps, guide, success, .. } = metrics;
        let speed = self.speed(*env_steps);
        let line = format!(
            "{:>9} steps  {}  guide {guide}  {} steps/s  {}",
            thousands(*env_steps),
            self.course.rates(success.iter().map(|rate| rate.map(f64::from))),
            thousands(speed as u64),
            self.course.left(*env_steps, self.last, speed),
        );
        self.since = [self.since[1], (Instant::now(), *env_steps)];
        match &self.bar {
            Some(bar) => bar.suspend(|| self.printer.note(line)),
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
