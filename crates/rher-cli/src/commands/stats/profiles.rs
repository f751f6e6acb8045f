//! Statistics as pictures: performance profiles and probability of improvement.
//!
//! Agarwal et al. (2021), "Deep Reinforcement Learning at the Edge of the Statistical Precipice":
//! what share of runs is at least as good as any threshold, not only what they are on average.

use super::numbers::{Comparison, Estimate, SOLVED, Stats, Time, env_steps, times, wall_s};
use crate::plot::{
    Axis, Clock, Curve, Intervals, LinePanel, Looks, Measure, Panel, Row, View, by_task, name,
};
use rher_runs::{Evaluation, Group, Run};

/// What a picture of them does not say.
pub(crate) const PROFILES: &str = "\
Lines: share of the n runs whose last evaluation has at least this success, and of those that had \
reached 95 % by then. Dots: probability that a run of the first group is better than one of the \
second; dashed: no difference. Bands and bars: 95 % bootstrap intervals over runs.";

/// For each task a row of profiles, and one of comparisons if there are several groups.
pub(crate) fn profiles(groups: &[(Group, Vec<Run>)], stats: &Stats) -> Vec<Vec<Panel>> {
    let looks = Looks::of(groups.iter().map(|(group, _)| name(group)));
    by_task(groups)
        .flat_map(|groups| {
            let task = &groups[0].0.task;
            let of_task = |comparison: &&Comparison| comparison.task == *task;
            let comparisons: Vec<_> = stats.comparisons.iter().filter(of_task).collect();
            let profiles = vec![
                final_success(groups, &looks),
                reached(groups, &looks, Clock::Steps, env_steps),
                reached(groups, &looks, Clock::Time, |evaluation| wall_s(evaluation) / 60.0),
            ];
            let compared = [
                ("higher final success", (|it| it.success_final) as fn(&Comparison) -> Estimate),
                ("95 % in fewer steps", |it| it.env_steps),
                ("95 % in less time", |it| it.wall_s),
            ];
            let compared = compared.map(|(title, estimate)| {
                intervals(format!("{task}: {title}"), &comparisons, &looks, estimate)
            });
            let rows = [profiles, compared.into_iter().flatten().collect()];
            rows.into_iter().filter(|row| !row.is_empty())
        })
        .collect()
}

/// Which share of runs ended with at least any success.
fn final_success(groups: &[(Group, Vec<Run>)], looks: &Looks) -> Panel {
    let thresholds: Vec<f64> = (0..=100).map(|percent| f64::from(percent) / 100.0).collect();
    let curve = |run: &Run| {
        let reaches = |threshold: &f64| f64::from(run.last().reaches(*threshold));
        thresholds.iter().map(|threshold| (*threshold, reaches(threshold))).collect()
    };
    let line = |(group, runs): &(Group, Vec<Run>)| {
        let curves: Vec<Curve> = runs.iter().map(curve).collect();
        shares(Clock::Steps).line(curves, looks.get(&name(group)))
    };
    let title = format!("{}: final success", groups[0].0.task);
    let lines = groups.iter().filter_map(line).collect();
    Panel::Lines(LinePanel {
        title,
        x: Axis::shares("at least this success"),
        y: Axis::shares(""),
        lines,
    })
}

/// Which share of runs had reached 95 % at any time.
fn reached(
    groups: &[(Group, Vec<Run>)],
    looks: &Looks,
    clock: Clock,
    time: fn(&Evaluation) -> f64,
) -> Panel {
    // A step of a line is drawn from just before.
    const BEFORE: f64 = 1.0 - 1e-9;
    let view = shares(clock);
    let end = view.end(groups);
    let line = |(group, runs): &(Group, Vec<Run>)| {
        let solved = times(runs, SOLVED, time);
        let mut moments = vec![0.0, end];
        for time in &solved {
            if let Time::At(time) = time {
                moments.extend([time * BEFORE, *time]);
            }
        }
        moments.sort_by(f64::total_cmp);
        moments.dedup();
        let curve = |time: &Time| -> Curve {
            let by = |moment: f64| f64::from(time.or_never() <= moment);
            moments.iter().map(|moment| (*moment, by(*moment))).collect()
        };
        view.line(solved.iter().map(curve).collect(), looks.get(&name(group)))
    };
    let title = format!("{}: reached 95 %", groups[0].0.task);
    Panel::Lines(view.shares(title, groups.iter().filter_map(line).collect(), end))
}

/// Shares of runs.
const fn shares(clock: Clock) -> View {
    View { clock, measure: Measure::Mean }
}

/// How probable it is that the first of two groups is better; `None` if there is no pair.
fn intervals(
    title: String,
    comparisons: &[&Comparison],
    looks: &Looks,
    estimate: fn(&Comparison) -> Estimate,
) -> Option<Panel> {
    let row = |comparison: &&Comparison| {
        let Comparison { of, over, .. } = comparison;
        let Estimate { value, ci95 } = estimate(comparison);
        let interval = ci95.and_then(|[low, high]| Some([low?, high?]));
        Some(Row {
            name: format!("{of} over {over}"),
            ink: looks.get(of).ink,
            value: value?,
            interval,
        })
    };
    let rows: Vec<Row> = comparisons.iter().filter_map(row).collect();
    let x = Axis::shares("probability");
    (!rows.is_empty()).then_some(Panel::Intervals(Intervals { title, x, reference: 0.5, rows }))
}
