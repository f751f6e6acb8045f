//! When a run is expected to be solved.

use crate::published::{Published, PublishedRun};
use rher_core::config::{Method, Preset, TrainConfig};

/// Evaluations whose mean counts: one alone is noisy.
const SMOOTHED: usize = 3;

/// Levels that differ by less, in percent, are the same.
const SAME: f64 = 2.0;

/// What one evaluation of a run found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) env_steps: u64,
    /// Mean success of all sub-tasks, in percent.
    pub(crate) mean: f64,
    /// Whether the whole task reached the success rate that ends the run.
    pub(crate) reached: bool,
}

/// The published runs that a run with these settings can be compared with, if there are any.
pub(crate) fn usual(config: &TrainConfig) -> Option<Published> {
    let published = Published::of(&config.task)?;
    let is_usual = config.preset == Preset::Fast && config.relay.method == Method::Rher;
    let ends_there = config.until > 0.0 && config.until <= published.until;
    (is_usual && ends_there).then_some(published)
}

/// The step at which a run will be solved, at a guess, from all of its evaluations; `interval` is
/// the steps from one to the next.
///
/// A published run tells what is left from where it stood on the same level: the mean success of all
/// sub-tasks, in the best three consecutive evaluations so far. If this run has stayed on its level
/// for some steps, the other one is that much further, too, but not further than it stayed on that
/// level itself; what this run has stayed longer, it is expected to stay once more. The guess is the
/// median over the published runs.
pub(crate) fn end(published: &Published, found: &[Found], interval: u64) -> u64 {
    let Some(last) = found.last() else { return median(published.ends()) };
    if last.reached {
        // One more evaluation, if that reaches the rate as well.
        return last.env_steps + interval * 3 / 2;
    }
    let mine = levels(found.iter().map(|found| found.mean));
    let level = mine[mine.len() - 1];
    let since = mine.iter().position(|it| *it >= level - SAME).unwrap_or(0);
    let stayed = last.env_steps - found[since].env_steps;
    let left = published.runs.iter().map(|run| left(run, level, stayed).max(2 * interval));
    last.env_steps + median(left.collect())
}

/// Steps that a published run took from a level to its end, after as many steps on the level as
/// `stayed`.
fn left(run: &PublishedRun, level: f64, stayed: u64) -> u64 {
    let levels = levels(run.course.iter().map(|rate| f64::from(*rate)));
    let steps = |evaluation: usize| run.interval * (evaluation as u64 + 1);
    let Some(first) = levels.iter().position(|it| *it >= level - SAME) else { return stayed };
    let last = levels.iter().rposition(|it| *it <= level + SAME).unwrap_or(first).max(first);
    let (here, leaves) = (steps(first) + stayed, steps(last));
    if here <= leaves { run.env_steps() - here } else { run.env_steps() - leaves + (here - leaves) }
}

/// The best mean of consecutive evaluations so far, at each of them.
fn levels(means: impl Iterator<Item = f64>) -> Vec<f64> {
    let means: Vec<f64> = means.collect();
    let mut best = 0.0_f64;
    let level = |end: usize| {
        let latest = &means[(end + 1).saturating_sub(SMOOTHED)..=end];
        best = best.max(latest.iter().sum::<f64>() / latest.len() as f64);
        best
    };
    (0..means.len()).map(level).collect()
}

/// The middle one, or the mean of the two in the middle.
fn median(mut numbers: Vec<u64>) -> u64 {
    numbers.sort_unstable();
    let middle = numbers.len() / 2;
    if numbers.len().is_multiple_of(2) {
        u64::midpoint(numbers[middle - 1], numbers[middle])
    } else {
        numbers[middle]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::archive::Archived;
    use std::collections::BTreeMap;

    fn published(courses: &[&[u8]]) -> Published {
        let run =
            |course: &&[u8]| PublishedRun { interval: 10, wall_s: 1, course: course.to_vec() };
        Published { until: 0.95, runs: courses.iter().map(run).collect() }
    }

    /// Evaluations every ten steps.
    fn found(means: &[f64]) -> Vec<Found> {
        let found = |(index, mean): (usize, &f64)| Found {
            env_steps: 10 * (index as u64 + 1),
            mean: *mean,
            reached: *mean >= 95.0,
        };
        means.iter().enumerate().map(found).collect()
    }

    #[test]
    fn before_its_first_evaluation_a_run_ends_as_others_did() {
        let runs = published(&[&[0; 4], &[0; 5], &[0; 9]]);
        assert_eq!(end(&runs, &[], 10), 50);
        assert_eq!(end(&published(&[&[0; 4], &[0; 6]]), &[], 10), 50);
    }

    #[test]
    fn a_run_that_is_ahead_ends_sooner() {
        let runs = published(&[&[0, 0, 20, 40, 60, 80, 90, 96, 96]]);
        let at = |means: &[f64]| end(&runs, &found(means), 10);
        assert_eq!(at(&[0.0, 0.0, 20.0]), 90);
        assert!(at(&[20.0, 60.0]) < 90);
        assert!(at(&[0.0, 0.0, 0.0, 0.0, 0.0, 20.0]) > 90);
    }

    #[test]
    fn a_run_that_stays_on_a_level_longer_than_others_is_expected_to_stay() {
        let runs = published(&[&[50, 50, 50, 50, 96, 96]]);
        let at = |evaluations: usize| end(&runs, &found(&vec![50.0; evaluations]), 10);
        assert_eq!([at(1), at(3)], [60, 60]);
        // Four evaluations longer, four more to stay, and two to the end.
        assert_eq!(at(8), 80 + 40 + 20);
    }

    #[test]
    fn the_rate_has_to_be_reached_once_more() {
        let runs = published(&[&[50, 96, 96]]);
        assert_eq!(end(&runs, &found(&[50.0, 60.0, 96.0]), 10), 45);
    }

    #[test]
    fn only_the_usual_settings_have_usual_ends() {
        let config = |preset: Preset| preset.config("push", 1);
        assert!(usual(&config(Preset::Fast)).is_some());
        assert!(usual(&config(Preset::Paper)).is_none());
        assert!(usual(&TrainConfig { until: 0.0, ..config(Preset::Fast) }).is_none());
        assert!(usual(&TrainConfig { until: 0.99, ..config(Preset::Fast) }).is_none());
        assert!(usual(&Preset::Fast.config("mine", 1)).is_none());
    }

    /// For each task, the evaluations of archived runs from the second on but for the last, and how
    /// many of them expect at least half and at most twice of what was left.
    ///
    /// A run is not compared with itself where there are others.
    fn within_a_factor_of_two(kind: &str) -> BTreeMap<String, [usize; 2]> {
        let published = Archived::all("target");
        let mut counts = BTreeMap::new();
        for run in Archived::all(kind) {
            let mine = run.published();
            let mut runs = published.iter().filter(|other| other.task == run.task);
            let all: Vec<PublishedRun> = runs.by_ref().map(Archived::published).collect();
            let (same, mut others): (Vec<_>, Vec<_>) = all.into_iter().partition(|it| *it == mine);
            if others.is_empty() {
                others = same;
            }
            let published = Published { until: run.until as f32, runs: others };
            let found: Vec<Found> = run
                .evaluations
                .iter()
                .zip(&mine.course)
                .map(|(evaluation, mean)| Found {
                    env_steps: evaluation.env_steps,
                    mean: f64::from(*mean),
                    reached: evaluation.reaches(run.until),
                })
                .collect();
            for seen in 2..found.len() {
                let now = found[seen - 1].env_steps;
                let expected = end(&published, &found[..seen], mine.interval) - now;
                let truth = mine.env_steps() - now;
                let [within, all] = counts.entry(run.task.clone()).or_insert([0; 2]);
                *within += usize::from(truth <= 2 * expected && expected <= 2 * truth);
                *all += 1;
            }
        }
        counts
    }

    /// The tables of `docs/archive/expected.md`.
    #[test]
    fn archived_runs_end_about_when_they_are_expected_to() {
        let table = |kind: &str| {
            let counts = within_a_factor_of_two(kind).into_iter();
            let rows = counts.map(|(task, [within, all])| format!("{task} {within} of {all}"));
            rows.collect::<Vec<_>>().join(", ")
        };
        assert_eq!(
            table("target"),
            "cue-push 1 of 1, dpush 23 of 33, drawer 1 of 1, drawer-box 43 of 57, insert 3 of 3, \
             obstacle-push 13 of 13, pick 19 of 19, push 12 of 12, slide 33 of 36, stack 46 of 49, \
             tpush 29 of 49, tstack 37 of 38"
        );
        assert_eq!(table("ordered"), "dpush 49 of 49, pick 7 of 7, push 16 of 16");
        assert_eq!(table("bf16"), "dpush 52 of 57, pick 9 of 9, push 11 of 11");
    }
}
