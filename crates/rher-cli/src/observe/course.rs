//! A run as those who look on know it: where it stands, and when it may end.

use crate::expected::{self, Found};
use crate::numbers::{duration, percent, range_of_steps, thousands};
use crate::published::Published;
use rher_core::config::TrainConfig;

/// Bars of a picture of success, from 0 to 1.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Most bars of a picture of success.
const MOST_BARS: usize = 40;

/// A run as those who look on know it.
pub(crate) struct Course {
    /// Names of the sub-tasks.
    subtasks: Vec<String>,
    /// Budget in environment steps.
    env_steps: u64,
    /// Steps from one evaluation to the next.
    interval: u64,
    until: f32,
    /// What it can be compared with.
    usual: Option<Published>,
    found: Vec<Found>,
    /// Success of the whole task in every evaluation.
    success: Vec<f64>,
    /// The step at which it will end, at a guess: with the budget, where nobody knows better.
    end: u64,
}

impl Course {
    /// A run that has not been evaluated yet; `subtasks` are the names of its sub-tasks.
    pub(crate) fn new(config: &TrainConfig, subtasks: Vec<String>, episode_steps: usize) -> Self {
        let interval = config.evaluation.every_episodes * episode_steps as u64;
        let TrainConfig { env_steps, until, .. } = *config;
        let (usual, found, success) = (expected::usual(config), Vec::new(), Vec::new());
        let mut course =
            Self { subtasks, env_steps, interval, until, usual, found, success, end: env_steps };
        course.guess();
        course
    }

    /// Takes in an evaluation: the success of each sub-task, and of the whole task.
    pub(crate) fn evaluated(&mut self, env_steps: u64, success: &[Option<f64>], whole: f64) {
        let trained: Vec<f64> = success.iter().flatten().copied().collect();
        let mean = 100.0 * trained.iter().sum::<f64>() / trained.len().max(1) as f64;
        // Rates are read with the digits of a single-precision number.
        let reached = self.until > 0.0 && whole as f32 >= self.until;
        self.found.push(Found { env_steps, mean, reached });
        self.success.push(whole);
        self.guess();
    }

    fn guess(&mut self) {
        if let Some(usual) = &self.usual {
            self.end = expected::end(usual, &self.found, self.interval).min(self.env_steps);
        }
    }

    /// The step at which it will end, at a guess, if it is at `now`.
    pub(crate) fn end(&self, now: u64) -> u64 {
        self.end.max(now)
    }

    /// `reach 100 % · push 88 %`.
    pub(crate) fn rates(&self, success: &[Option<f64>]) -> String {
        let rates = self
            .subtasks
            .iter()
            .zip(success)
            .map(|(name, rate)| format!("{name} {}", rate.map_or("–".to_owned(), percent)));
        rates.collect::<Vec<_>>().join(" · ")
    }

    /// Success in the latest evaluations as a picture, `▁▃▇ 88 %`; empty before the first one.
    pub(crate) fn picture(&self) -> String {
        let Some(last) = self.success.last() else { return String::new() };
        let bar = |rate: &f64| BARS[((rate * BARS.len() as f64) as usize).min(BARS.len() - 1)];
        let shown = &self.success[self.success.len().saturating_sub(MOST_BARS)..];
        format!("{} {}", shown.iter().map(bar).collect::<String>(), percent(*last))
    }

    /// `about 20 s to go, at most 9 min 30 s`, at `speed` steps in a second; `solved` after the last
    /// evaluation.
    pub(crate) fn left(&self, now: u64, speed: f64) -> String {
        if self.is_solved() {
            return "solved".to_owned();
        }
        let time = |steps: u64| duration(steps.saturating_sub(now) as f64 / speed);
        let most = time(self.env_steps);
        match self.usual {
            Some(_) => format!("about {} to go, at most {most}", time(self.end(now))),
            None if self.until > 0.0 => format!("at most {most} to go"),
            None => format!("{most} to go"),
        }
    }

    /// Whether the latest two evaluations reached the success rate that ends the run.
    fn is_solved(&self) -> bool {
        self.found.last_chunk::<2>().is_some_and(|two| two.iter().all(|found| found.reached))
    }

    /// What is known before a run begins, if anything.
    pub(crate) fn usually(&self) -> Option<String> {
        let usual = self.usual.as_ref()?.ends();
        if *usual.last()? > self.env_steps {
            return None;
        }
        Some(format!(
            "goal: {} in two consecutive evaluations, which usually takes {}, at most {}",
            percent(f64::from(self.until)),
            range_of_steps(&usual),
            thousands(self.env_steps)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rher_core::config::Preset;

    #[test]
    fn success_is_pictured() {
        let mut course = Course::new(&Preset::Fast.config("push", 1), Vec::new(), 50);
        assert_eq!(course.picture(), "");
        for (index, rate) in [0.0, 0.07, 0.5, 0.88, 1.0].into_iter().enumerate() {
            course.evaluated(2_500 * (index as u64 + 1), &[Some(1.0), Some(rate)], rate);
        }
        assert_eq!(course.picture(), "▁▁▅██ 100 %");
        for index in 0..MOST_BARS {
            course.evaluated(12_500 + 2_500 * (index as u64 + 1), &[Some(1.0), Some(0.3)], 0.3);
        }
        assert_eq!(course.picture(), "▃".repeat(MOST_BARS) + " 30 %");
    }

    #[test]
    fn a_guess_is_never_behind_the_run_or_beyond_its_budget() {
        let config = TrainConfig { env_steps: 20_000, ..Preset::Fast.config("push", 1) };
        let mut course = Course::new(&config, Vec::new(), 50);
        assert_eq!(course.end(0), 10_000);
        for evaluation in 1..=8 {
            course.evaluated(2_500 * evaluation, &[Some(1.0), Some(0.5)], 0.5);
            let end = course.end(2_500 * evaluation);
            assert!((2_500 * evaluation..=20_000).contains(&end), "{end}");
        }
        assert_eq!(course.left(20_000, 100.0), "about 0 s to go, at most 0 s");
        for evaluation in 9..=10 {
            course.evaluated(2_500 * evaluation, &[Some(1.0), Some(0.96)], 0.96);
        }
        assert_eq!(course.left(25_000, 100.0), "solved");
    }
}
