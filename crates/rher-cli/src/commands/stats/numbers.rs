//! What runs reached, as numbers: each with an interval over runs, and compared by pairs of groups.

use crate::cells::Row;
use crate::plot::name;
use crate::plot::statistics::{
    greater, interquartile_mean, interval, interval_of_two, mean, median,
    probability_of_improvement,
};
use rher_runs::{Evaluation, Group, Run};
use serde::Serialize;

/// Success rates whose first time is told.
pub(super) const RATES: [f64; 4] = [0.5, 0.8, 0.9, 0.95];

/// The rate by which two groups are compared: training ends there by default.
pub(super) const SOLVED: f64 = 0.95;

/// What is printed.
#[derive(Serialize)]
pub(crate) struct Stats {
    /// Cells of plans that are not at their end.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) unfinished: Vec<Row>,
    pub(super) groups: Vec<GroupStats>,
    pub(super) comparisons: Vec<Comparison>,
}

#[derive(Serialize)]
pub(super) struct GroupStats {
    #[serde(flatten)]
    pub(super) group: Group,
    pub(super) seeds: Vec<u64>,
    /// Of each run's last evaluation.
    pub(super) success_final: Estimate,
    pub(super) success_final_iqm: Estimate,
    pub(super) reached: Vec<Reached>,
}

/// When runs first reached a success rate.
#[derive(Serialize)]
pub(super) struct Reached {
    pub(super) rate: f64,
    /// How many runs did.
    pub(super) runs: usize,
    /// The median run; `null` if it never did.
    pub(super) env_steps: Estimate,
    /// The median run; `null` if it never did.
    pub(super) wall_s: Estimate,
}

/// A number and its 95 % interval, which a single run has not.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Estimate {
    pub(super) value: Option<f64>,
    pub(super) ci95: Option<[Option<f64>; 2]>,
}

/// How probable it is that a run of one group is better than a run of the other.
#[derive(Serialize)]
pub(super) struct Comparison {
    pub(super) task: String,
    pub(super) of: String,
    pub(super) over: String,
    /// Higher success at the last evaluation.
    pub(super) success_final: Estimate,
    /// 95 % success after fewer environment steps.
    pub(super) env_steps: Estimate,
    /// 95 % success after less wall clock.
    pub(super) wall_s: Estimate,
}

/// When a run first reached a success rate.
#[derive(Clone, Copy)]
pub(super) enum Time {
    At(f64),
    /// It ended before, at this time.
    NotBy(f64),
}

impl Stats {
    pub(crate) fn of(groups: &[(Group, Vec<Run>)], unfinished: Vec<Row>) -> Self {
        Self {
            unfinished,
            groups: groups.iter().map(|(group, runs)| GroupStats::of(group, runs)).collect(),
            comparisons: compare_all(groups),
        }
    }
}

impl GroupStats {
    fn of(group: &Group, runs: &[Run]) -> Self {
        let last: Vec<f64> = runs.iter().map(|run| run.last().success_final).collect();
        Self {
            group: group.clone(),
            seeds: runs.iter().map(|run| run.seed).collect(),
            success_final: Estimate::of(&last, mean),
            success_final_iqm: Estimate::of(&last, interquartile_mean),
            reached: RATES.map(|rate| Reached::of(runs, rate)).into(),
        }
    }
}

impl Reached {
    fn of(runs: &[Run], rate: f64) -> Self {
        let estimate = |clock: fn(&Evaluation) -> f64| {
            let times = times(runs, rate, clock);
            let or_never: Vec<f64> = times.iter().map(|time| time.or_never()).collect();
            Estimate::of(&or_never, median)
        };
        let reached = |time: &&Time| matches!(time, Time::At(_));
        Self {
            rate,
            runs: times(runs, rate, env_steps).iter().filter(reached).count(),
            env_steps: estimate(env_steps),
            wall_s: estimate(wall_s),
        }
    }
}

impl Estimate {
    fn of(runs: &[f64], statistic: fn(&[f64]) -> f64) -> Self {
        Self::new(statistic(runs), interval(runs, statistic))
    }

    fn of_two<T: Copy>(first: &[T], second: &[T], advantage: impl Fn(T, T) -> f64) -> Self {
        let probability = |a: &[T], b: &[T]| probability_of_improvement(a, b, &advantage);
        Self::new(probability(first, second), interval_of_two(first, second, probability))
    }

    /// An infinite number is `None`: JSON has no other word for never.
    fn new(value: f64, ci95: Option<[f64; 2]>) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        Self { value: finite(value), ci95: ci95.map(|bounds| bounds.map(finite)) }
    }
}

impl Time {
    pub(super) const fn or_never(self) -> f64 {
        match self {
            Self::At(time) => time,
            Self::NotBy(_) => f64::INFINITY,
        }
    }

    /// How much it counts that this is earlier; nobody knows what a run would have done that
    /// ended before the other got there.
    fn earlier_than(self, other: Self) -> f64 {
        match (self, other) {
            (Self::At(a), Self::At(b)) => greater(b, a),
            (Self::At(a), Self::NotBy(end)) if end >= a => 1.0,
            (Self::NotBy(end), Self::At(b)) if end >= b => 0.0,
            _ => 0.5,
        }
    }
}

pub(super) fn env_steps(evaluation: &Evaluation) -> f64 {
    evaluation.env_steps as f64
}

pub(super) fn wall_s(evaluation: &Evaluation) -> f64 {
    evaluation.wall_s
}

/// When each run first had a success rate of at least `rate`.
pub(super) fn times(runs: &[Run], rate: f64, clock: impl Fn(&Evaluation) -> f64) -> Vec<Time> {
    runs.iter()
        .map(|run| {
            let reached = |evaluation: &&Evaluation| evaluation.reaches(rate);
            match run.evaluations.iter().find(reached) {
                Some(evaluation) => Time::At(clock(evaluation)),
                None => Time::NotBy(clock(run.last())),
            }
        })
        .collect()
}

/// Every two groups of the same task, the one that is named first over the other.
fn compare_all(groups: &[(Group, Vec<Run>)]) -> Vec<Comparison> {
    let pairs = groups.iter().enumerate().flat_map(|(index, first)| {
        let others = groups[index + 1..].iter();
        others.filter(|(group, _)| group.task == first.0.task).map(move |second| (first, second))
    });
    pairs.map(|(first, second)| compare(first, second)).collect()
}

fn compare((of, first): &(Group, Vec<Run>), (over, second): &(Group, Vec<Run>)) -> Comparison {
    let last =
        |runs: &[Run]| -> Vec<f64> { runs.iter().map(|run| run.last().success_final).collect() };
    let sooner = |clock: fn(&Evaluation) -> f64| {
        let (first, second) = (times(first, SOLVED, clock), times(second, SOLVED, clock));
        Estimate::of_two(&first, &second, Time::earlier_than)
    };
    Comparison {
        task: of.task.clone(),
        of: name(of),
        over: name(over),
        success_final: Estimate::of_two(&last(first), &last(second), greater),
        env_steps: sooner(env_steps),
        wall_s: sooner(wall_s),
    }
}
