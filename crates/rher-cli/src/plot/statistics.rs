//! What a few runs say about all runs there could be.
//!
//! Agarwal et al. (2021), "Deep Reinforcement Learning at the Edge of the Statistical Precipice":
//! interquartile means, and percentile bootstrap intervals over runs.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Resamples of an interval.
const RESAMPLES: usize = 2000;

/// The same resamples in every invocation, so that output repeats.
const SEED: u64 = 0;

/// The arithmetic mean.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean without the lowest and the highest quarter, rounded down: with three values or fewer,
/// of all of them.
pub(crate) fn interquartile_mean(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let cut = sorted.len() / 4;
    mean(&sorted[cut..sorted.len() - cut])
}

/// The value in the middle, the upper one of two.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// The share of pairs in which the first is better, ties counting half.
pub(crate) fn probability_of_improvement<T: Copy>(
    first: &[T],
    second: &[T],
    advantage: impl Fn(T, T) -> f64,
) -> f64 {
    let pairs = first.iter().flat_map(|&a| second.iter().map(move |&b| (a, b)));
    pairs.map(|(a, b)| advantage(a, b)).sum::<f64>() / (first.len() * second.len()) as f64
}

/// How much `a > b` counts: 1, 0, or ½ for a tie.
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if a > b {
        1.0
    } else if a < b {
        0.0
    } else {
        0.5
    }
}

/// The 95 % interval of a statistic of runs; `None` for a single run, which has no spread.
pub(crate) fn interval<T: Copy>(runs: &[T], statistic: impl Fn(&[T]) -> f64) -> Option<[f64; 2]> {
    if runs.len() < 2 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let draws = (0..RESAMPLES).map(|_| statistic(&resample(runs, &mut rng)));
    Some(middle(draws.collect()))
}

/// The same for a statistic of two sets of runs, resampled each by itself.
pub(crate) fn interval_of_two<T: Copy>(
    first: &[T],
    second: &[T],
    statistic: impl Fn(&[T], &[T]) -> f64,
) -> Option<[f64; 2]> {
    if first.len() < 2 || second.len() < 2 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let draws =
        (0..RESAMPLES).map(|_| statistic(&resample(first, &mut rng), &resample(second, &mut rng)));
    Some(middle(draws.collect()))
}

fn resample<T: Copy>(runs: &[T], rng: &mut ChaCha8Rng) -> Vec<T> {
    runs.iter().map(|_| runs[rng.random_range(0..runs.len())]).collect()
}

/// Between which values the middle 95 % lie; a value may be infinite.
fn middle(mut draws: Vec<f64>) -> [f64; 2] {
    draws.sort_by(f64::total_cmp);
    let outside = draws.len() / 40;
    [draws[outside], draws[draws.len() - 1 - outside]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(actual: f64, expected: f64) {
        assert!((actual - expected).abs() < 1e-12, "{actual} is not {expected}");
    }

    #[test]
    fn the_interquartile_mean_leaves_outliers_out() {
        assert_close(interquartile_mean(&[0.0, 0.6, 0.8, 1.0]), 0.7);
        assert_close(interquartile_mean(&[0.3, 0.9, 0.6]), 0.6);
        assert_close(interquartile_mean(&[9.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -7.0]), 3.5);
    }

    #[test]
    fn improvement_is_the_share_of_pairs_won() {
        let of = |a: &[f64], b: &[f64]| probability_of_improvement(a, b, greater);
        assert_close(of(&[2.0, 3.0], &[1.0, 0.0]), 1.0);
        assert_close(of(&[1.0, 1.0], &[1.0, 1.0]), 0.5);
        assert_close(of(&[1.0, 3.0], &[2.0, 3.0]), 0.375);
    }

    #[test]
    fn an_interval_repeats_and_holds_the_statistic() {
        let runs = [0.95, 0.97, 0.9, 1.0, 0.93];
        let [low, high] = interval(&runs, mean).unwrap();
        assert!(0.9 < low && low < mean(&runs) && mean(&runs) < high && high < 1.0);
        assert_eq!(interval(&runs, mean), Some([low, high]));
        assert_eq!(interval(&[0.5, 0.5], mean), Some([0.5, 0.5]));
        assert_eq!(interval(&[0.5], mean), None);
    }

    #[test]
    fn an_interval_of_the_normal_mean_is_as_wide_as_theory_says() {
        // 1 to 400: the mean's standard error is 400 / √12 / √400, a 95 % interval 3.92 of them.
        let values: Vec<f64> = (1..=400).map(f64::from).collect();
        let [low, high] = interval(&values, mean).unwrap();
        let expected = 3.92 * 400.0 / 12.0_f64.sqrt() / 20.0;
        assert!(((high - low) / expected - 1.0).abs() < 0.06, "{} {expected}", high - low);
    }
}
