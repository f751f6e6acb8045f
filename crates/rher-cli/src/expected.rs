//! When a run is expected to be solved.

use rher_core::config::{Method, Preset, TrainConfig};
use rher_envs::Task;

/// Steps after which the published runs with the preset `fast` were solved (`docs/results.md`), in
/// increasing order; `slide` was not trained to 95 %.
const SOLVED_AFTER: [(Task, &[u64]); 12] = [
    (Task::REACH, &[1_000]),
    (Task::PUSH, &[10_000, 10_000, 10_000, 12_500, 12_500]),
    (Task::PICK, &[12_500, 12_500, 12_500, 15_000, 20_000]),
    (Task::INSERT, &[12_500]),
    (Task::OBSTACLE_PUSH, &[37_500]),
    (Task::DRAWER, &[5_000]),
    (Task::CUE_PUSH, &[3_000]),
    (Task::DPUSH, &[33_000, 33_000, 51_000]),
    (Task::STACK, &[51_000, 57_000, 57_000]),
    (Task::DRAWER_BOX, &[102_000, 168_000]),
    (Task::TPUSH, &[147_000, 224_000]),
    (Task::TSTACK, &[280_000]),
];

/// Steps after which such runs were solved; `None` where nobody knows.
pub(crate) fn usual(config: &TrainConfig) -> Option<&'static [u64]> {
    let task: Task = config.task.parse().ok()?;
    let is_usual = config.preset == Preset::Fast && config.relay.method == Method::Rher;
    let (_, steps) = SOLVED_AFTER.iter().find(|(of, _)| *of == task)?;
    (is_usual && config.until > 0.0).then_some(*steps)
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
    fn published_ends_are_in_order() {
        for (task, steps) in SOLVED_AFTER {
            assert!(!steps.is_empty() && steps.is_sorted(), "{task}");
        }
    }
}
