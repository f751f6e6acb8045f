//! `rher stats`: what runs reached, how soon, and how sure that is.

use crate::cells::Row;
use crate::chosen::{Chosen, UNFINISHED, unfinished};
use crate::cli::StatsArgs;
use crate::numbers::{duration, percent, thousands};
use crate::plot::statistics::{
    greater, interquartile_mean, interval, interval_of_two, mean, median,
    probability_of_improvement,
};
use crate::printer::Printer;
use crate::tables::{table, text};
use comfy_table::Table;
use comfy_table::presets::ASCII_MARKDOWN;
use rher_runs::{Evaluation, Group, Run};
use serde::Serialize;

/// Success rates whose first time is told.
const RATES: [f64; 4] = [0.5, 0.8, 0.9, 0.95];

/// What the tables do not say.
pub(super) const NOTE: &str = "In brackets: 95 % bootstrap intervals over runs, where there are \
                               several. Times are those of the median run.";

/// The rate by which two groups are compared: training ends there by default.
const SOLVED: f64 = 0.95;

/// What is printed.
#[derive(Serialize)]
pub(super) struct Stats {
    /// Cells of plans that are not at their end.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unfinished: Vec<Row>,
    groups: Vec<GroupStats>,
    comparisons: Vec<Comparison>,
}

#[derive(Serialize)]
struct GroupStats {
    #[serde(flatten)]
    group: Group,
    seeds: Vec<u64>,
    /// Of each run's last evaluation.
    success_final: Estimate,
    success_final_iqm: Estimate,
    reached: Vec<Reached>,
}

/// When runs first reached a success rate.
#[derive(Serialize)]
struct Reached {
    rate: f64,
    /// How many runs did.
    runs: usize,
    /// The median run; `null` if it never did.
    env_steps: Estimate,
    /// The median run; `null` if it never did.
    wall_s: Estimate,
}

/// A number and its 95 % interval, which a single run has not.
#[derive(Clone, Copy, Serialize)]
struct Estimate {
    value: Option<f64>,
    ci95: Option<[Option<f64>; 2]>,
}

/// How probable it is that a run of one group is better than a run of the other.
#[derive(Serialize)]
struct Comparison {
    task: String,
    of: String,
    over: String,
    /// Higher success at the last evaluation.
    success_final: Estimate,
    /// 95 % success after fewer environment steps.
    env_steps: Estimate,
    /// 95 % success after less wall clock.
    wall_s: Estimate,
}

/// When a run first reached a success rate.
#[derive(Clone, Copy)]
enum Time {
    At(f64),
    /// It ended before, at this time.
    NotBy(f64),
}

pub(crate) fn stats(args: &StatsArgs, printer: Printer) -> anyhow::Result<()> {
    let Chosen { groups, unfinished } = Chosen::read(&args.runs, printer)?;
    for (group, runs) in &groups {
        if runs.iter().any(|run| run.settings != runs[0].settings) {
            printer.note(format_args!(
                "note: the runs of {group} differ in more than the seed; compare their `config.toml`"
            ));
        }
    }
    let stats = Stats::of(&groups, unfinished);
    let output = if args.json {
        serde_json::to_string_pretty(&stats)?
    } else if args.markdown {
        describe(&stats, |mut table| {
            table.load_style(ASCII_MARKDOWN);
            table.to_string() + "\n"
        })
    } else {
        describe(&stats, |table| text(&table))
    };
    printer.data(&output)?;
    Ok(())
}

impl Stats {
    pub(super) fn of(groups: &[(Group, Vec<Run>)], unfinished: Vec<Row>) -> Self {
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

    fn show(self, number: impl Fn(f64) -> String) -> String {
        let show = |value: Option<f64>| value.map_or("never".to_owned(), &number);
        match self.ci95 {
            Some([low, high]) => format!("{} [{}, {}]", show(self.value), show(low), show(high)),
            None => show(self.value),
        }
    }
}

impl Time {
    const fn or_never(self) -> f64 {
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

fn env_steps(evaluation: &Evaluation) -> f64 {
    evaluation.env_steps as f64
}

fn wall_s(evaluation: &Evaluation) -> f64 {
    evaluation.wall_s
}

/// When each run first had a success rate of at least `rate`.
fn times(runs: &[Run], rate: f64, clock: impl Fn(&Evaluation) -> f64) -> Vec<Time> {
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
    let name = |group: &Group| format!("{} {}", group.method, group.preset);
    Comparison {
        task: of.task.clone(),
        of: name(of),
        over: name(over),
        success_final: Estimate::of_two(&last(first), &last(second), greater),
        env_steps: sooner(env_steps),
        wall_s: sooner(wall_s),
    }
}

fn describe(stats: &Stats, show: impl Fn(Table) -> String) -> String {
    let sections = sections(stats).into_iter();
    let mut texts: Vec<String> =
        sections.map(|(title, table)| format!("{title}\n\n{}", show(table))).collect();
    texts.push(format!("{NOTE}\n"));
    texts.join("\n")
}

/// Titles and tables.
pub(super) fn sections(stats: &Stats) -> Vec<(&'static str, Table)> {
    let mut success = table();
    success.set_header(["task", "method", "preset", "runs", "final success", "interquartile mean"]);
    let columns = RATES.map(percent);
    let header = ["task", "method", "preset"].map(str::to_owned).into_iter().chain(columns);
    let mut steps = table();
    steps.set_header(header.clone());
    let mut seconds = table();
    seconds.set_header(header);
    for GroupStats { group, seeds, success_final, success_final_iqm, reached } in &stats.groups {
        let Group { task, method, preset } = group;
        let name = [task, method, preset].map(String::clone);
        success.add_row(name.clone().into_iter().chain([
            seeds.len().to_string(),
            success_final.show(percent),
            success_final_iqm.show(percent),
        ]));
        let row = |show: &dyn Fn(&Reached) -> String| {
            let cell = |reached: &Reached| match (reached.runs, seeds.len()) {
                (0, _) => "never".to_owned(),
                (some, all) if some < all => format!("{} ({some} of {all})", show(reached)),
                _ => show(reached),
            };
            name.clone().into_iter().chain(reached.iter().map(cell).collect::<Vec<_>>())
        };
        let whole = |steps: f64| thousands(steps as u64);
        steps.add_row(row(&|reached| reached.env_steps.show(whole)));
        seconds.add_row(row(&|reached| reached.wall_s.show(duration)));
    }
    let mut sections = vec![
        ("Success at the last evaluation", success),
        ("Environment steps to the first evaluation of", steps),
        ("Wall clock to the first evaluation of", seconds),
    ];
    if !stats.comparisons.is_empty() {
        let mut comparisons = table();
        comparisons.set_header([
            "task",
            "a run of",
            "better than one of",
            "higher final success",
            "95 % in fewer steps",
            "95 % in less time",
        ]);
        for Comparison { task, of, over, success_final, env_steps, wall_s } in &stats.comparisons {
            let [success_final, env_steps, wall_s] =
                [success_final, env_steps, wall_s].map(|estimate| estimate.show(percent));
            comparisons.add_row([task, of, over, &success_final, &env_steps, &wall_s]);
        }
        sections.push(("Probability of improvement", comparisons));
    }
    sections.extend(unfinished(&stats.unfinished).map(|listing| (UNFINISHED, listing)));
    sections
}
