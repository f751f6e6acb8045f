//! When a run is expected to be solved.

use rher_core::config::{Method, Preset, TrainConfig};
use rher_envs::Task;
use serde::Serialize;

/// A published run of the preset `fast`, at the end of which it was solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct End {
    pub(crate) env_steps: u64,
    /// Seconds on one core.
    pub(crate) wall_s: u64,
}

const fn end_after(env_steps: u64, wall_s: u64) -> End {
    End { env_steps, wall_s }
}

/// The published runs of a task.
pub(crate) struct Published {
    task: Task,
    /// Success rate in two consecutive evaluations at which they ended.
    pub(crate) until: f32,
    /// In increasing order.
    pub(crate) ends: &'static [End],
}

/// The runs in `docs/archive/runs/<TASK>-target-seed*`.
const PUBLISHED: [Published; 13] = {
    const fn of(task: Task, until: f32, ends: &'static [End]) -> Published {
        Published { task, until, ends }
    }
    [
        of(Task::REACH, 0.95, &[end_after(1_000, 1)]),
        of(
            Task::PUSH,
            0.95,
            &[
                end_after(10_000, 25),
                end_after(10_000, 25),
                end_after(10_000, 26),
                end_after(12_500, 31),
                end_after(12_500, 32),
            ],
        ),
        of(
            Task::PICK,
            0.95,
            &[
                end_after(12_500, 32),
                end_after(12_500, 32),
                end_after(12_500, 36),
                end_after(15_000, 38),
                end_after(20_000, 53),
            ],
        ),
        of(Task::SLIDE, 0.9, &[end_after(95_000, 246)]),
        of(Task::INSERT, 0.95, &[end_after(12_500, 32)]),
        of(Task::OBSTACLE_PUSH, 0.95, &[end_after(37_500, 100)]),
        of(Task::DRAWER, 0.95, &[end_after(7_500, 20)]),
        of(Task::CUE_PUSH, 0.95, &[end_after(3_000, 18)]),
        of(
            Task::DPUSH,
            0.95,
            &[end_after(33_000, 80), end_after(33_000, 88), end_after(51_000, 121)],
        ),
        of(
            Task::STACK,
            0.95,
            &[end_after(51_000, 124), end_after(57_000, 146), end_after(57_000, 149)],
        ),
        of(
            Task::DRAWER_BOX,
            0.95,
            &[end_after(102_000, 134), end_after(108_000, 144), end_after(168_000, 212)],
        ),
        of(Task::TPUSH, 0.95, &[end_after(147_000, 261), end_after(224_000, 377)]),
        of(Task::TSTACK, 0.95, &[end_after(280_000, 952)]),
    ]
};

/// What is published of a task, if anything.
pub(crate) fn published(task: Task) -> Option<&'static Published> {
    PUBLISHED.iter().find(|published| published.task == task)
}

/// Steps after which such runs were solved, in increasing order; `None` where nobody knows.
pub(crate) fn usual(config: &TrainConfig) -> Option<Vec<u64>> {
    let Published { until, ends, .. } = published(config.task.parse().ok()?)?;
    let is_usual = config.preset == Preset::Fast && config.relay.method == Method::Rher;
    let ends_there = config.until > 0.0 && config.until <= *until;
    (is_usual && ends_there).then(|| ends.iter().map(|end| end.env_steps).collect())
}

/// The step at which a run at `now` will be solved, at a guess, with an evaluation every `interval`
/// steps; `solved` says whether the latest one reached the success rate, which takes two.
pub(crate) fn end(usual: &[u64], now: u64, interval: u64, solved: bool) -> u64 {
    if solved {
        return (now / interval + 1) * interval;
    }
    let later: Vec<u64> = usual.iter().copied().filter(|steps| *steps >= now + interval).collect();
    // Half of the runs that took longer; later than all of them, the longer the longer it took.
    later.get(later.len() / 2).copied().unwrap_or(now + (now / 4).max(2 * interval))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rher_runs::read_evaluations;

    #[test]
    fn runs_end_as_others_did_and_later_ones_later() {
        let usual = [10_000, 12_500, 15_000];
        assert_eq!(end(&usual, 0, 2_500, false), 12_500);
        assert_eq!(end(&usual, 10_000, 2_500, false), 15_000);
        assert_eq!(end(&usual, 10_000, 2_500, true), 12_500);
        assert_eq!(end(&usual, 40_000, 2_500, false), 50_000);
    }

    #[test]
    fn only_the_usual_settings_have_usual_ends() {
        let config = |preset: Preset| preset.config("push", 1);
        assert!(usual(&config(Preset::Fast)).is_some());
        assert_eq!(usual(&config(Preset::Paper)), None);
        assert_eq!(usual(&TrainConfig { until: 0.0, ..config(Preset::Fast) }), None);
        assert_eq!(usual(&Preset::Fast.config("mine", 1)), None);
    }

    #[test]
    fn what_is_published_is_in_the_archive() {
        let runs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/archive/runs");
        for Published { task, until, ends } in PUBLISHED {
            let prefix = format!("{task}-target-seed");
            let mut solved = Vec::new();
            for folder in std::fs::read_dir(runs).unwrap().map(|entry| entry.unwrap().path()) {
                if folder.file_name().unwrap().to_str().unwrap().starts_with(&prefix) {
                    let evaluations = read_evaluations(&folder, None).unwrap();
                    let until = until.into();
                    let mut two = evaluations.windows(2);
                    let two = two.find(|two| two.iter().all(|it| it.reaches(until))).unwrap();
                    solved.push(end_after(two[1].env_steps, two[1].wall_s.round() as u64));
                }
            }
            solved.sort_by_key(|end| (end.env_steps, end.wall_s));
            assert_eq!(solved, ends, "{task}");
        }
    }
}
