//! From runs to curves: one value for each run at every time, their middle, and a band around it.

use super::statistics::interval;

/// Success of one run over time, or of one sub-task of it.
pub(crate) type Curve = Vec<(f64, f64)>;

/// The middle of several curves, with a 95 % interval where there are several.
#[derive(Debug, PartialEq)]
pub(crate) struct Band {
    pub(crate) points: Curve,
    pub(crate) interval: Option<Vec<[f64; 2]>>,
}

/// The statistic of `curves` at every time that one of them has, from when all have begun.
///
/// A run that has ended keeps its last value: it ended because it was solved or told to.
pub(crate) fn summarize(curves: &[Curve], statistic: impl Fn(&[f64]) -> f64) -> Band {
    let begin = curves.iter().map(|curve| curve[0].0).fold(0.0, f64::max);
    let mut times: Vec<f64> =
        curves.iter().flatten().map(|point| point.0).filter(|time| *time >= begin).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let values =
        |time: &f64| curves.iter().map(|curve| value_at(curve, *time)).collect::<Vec<f64>>();
    let points = times.iter().map(|time| (*time, statistic(&values(time)))).collect();
    let interval = times.iter().map(|time| interval(&values(time), &statistic)).collect();
    Band { points, interval }
}

/// Linear between points, constant outside of them.
pub(super) fn value_at(curve: &Curve, time: f64) -> f64 {
    let after = curve.partition_point(|point| point.0 <= time);
    let before = curve[after.saturating_sub(1)];
    match curve.get(after) {
        Some(next) if after > 0 => {
            before.1 + (next.1 - before.1) * (time - before.0) / (next.0 - before.0)
        }
        _ => before.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::statistics::mean;

    #[test]
    fn a_run_that_ended_keeps_its_last_value() {
        let curves = [vec![(1.0, 0.0), (2.0, 1.0)], vec![(1.0, 0.0), (4.0, 0.6)]];
        let Band { points, interval } = summarize(&curves, mean);
        let rounded = points.iter().map(|(time, value)| (*time, (value * 1e6).round() / 1e6));
        assert_eq!(rounded.collect::<Vec<_>>(), [(1.0, 0.0), (2.0, 0.6), (4.0, 0.8)]);
        assert_eq!(interval.unwrap().len(), 3);
    }

    #[test]
    fn a_single_run_has_no_band() {
        assert_eq!(summarize(&[vec![(1.0, 0.5)]], mean).interval, None);
    }
}
