//! Numbers of evaluations as panels: against which clock, and which statistic of several runs.

use super::chart::{Axis, Line, LinePanel, Look, Panel};
use super::curves::{Band, Curve, summarize};
use super::looks::Looks;
use super::statistics::{interquartile_mean, mean};
use crate::numbers::thousands;
use clap::ValueEnum;
use rher_runs::{Evaluation, Group, Run};

/// What curves are drawn against.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum Clock {
    /// Environment steps of training
    Steps,
    /// Wall clock
    Time,
}

/// What is shown of several runs.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Measure {
    /// The mean
    Mean,
    /// The interquartile mean
    Iqm,
}

/// How runs become lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) clock: Clock,
    pub(crate) measure: Measure,
}

/// What evaluations say of one thing: a number, or one for each of several parts.
pub(crate) struct Quantity {
    pub(crate) title: String,
    pub(crate) unit: Unit,
    pub(crate) series: Vec<Series>,
}

/// Which numbers a quantity has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    /// From 0 to 1.
    Share,
    /// Any.
    Number,
}

/// One number of every evaluation of a run.
pub(crate) struct Series {
    pub(crate) look: Look,
    pub(crate) values: Values,
}

/// What each evaluation of a run says, where it says it.
pub(crate) type Values = Box<dyn Fn(&Run) -> Vec<Option<f64>>>;

impl View {
    /// The panels of a quantity of runs of one task, up to `end`: one in which groups are compared,
    /// or one for each group where it has several parts. Panels without a line are left out.
    pub(crate) fn panels(
        self,
        quantity: &Quantity,
        groups: &[(Group, Vec<Run>)],
        looks: &Looks,
        end: f64,
    ) -> Vec<Panel> {
        let Quantity { title, unit, series } = quantity;
        let panel = |title: String, lines: Vec<Option<Line>>| {
            self.panel(title, *unit, lines.into_iter().flatten().collect(), end)
        };
        let panels: Vec<LinePanel> = if let [series] = series.as_slice() {
            let line = |(group, runs): &(Group, Vec<Run>)| {
                self.line(self.curves(runs, series), looks.get(&name(group)))
            };
            vec![panel(title.clone(), groups.iter().map(line).collect())]
        } else {
            let of_group = |(group, runs): &(Group, Vec<Run>)| {
                let title = match groups {
                    [_] => title.clone(),
                    _ => format!("{title}, {}", name(group)),
                };
                let line =
                    |series: &Series| self.line(self.curves(runs, series), series.look.clone());
                panel(title, series.iter().map(line).collect())
            };
            groups.iter().map(of_group).collect()
        };
        panels.into_iter().filter(|panel| !panel.lines.is_empty()).map(Panel::Lines).collect()
    }

    /// Lines that are shares, up to `end`.
    pub(crate) fn shares(self, title: String, lines: Vec<Line>, end: f64) -> LinePanel {
        self.panel(title, Unit::Share, lines, end)
    }

    /// Lines over the axes of this view.
    fn panel(self, title: String, unit: Unit, lines: Vec<Line>, end: f64) -> LinePanel {
        let x = match self.clock {
            Clock::Steps => Axis::to("environment steps", end, |steps| {
                thousands(steps.round() as u64) + " environment steps"
            }),
            Clock::Time => {
                Axis::to("wall clock, minutes", end, |minutes| format!("{minutes:.2} minutes"))
            }
        };
        let y = match unit {
            Unit::Share => Axis::shares(""),
            Unit::Number => {
                let points = lines.iter().flat_map(|line| &line.points).map(|point| point.1);
                let bounds = lines.iter().filter_map(|line| line.band.as_ref()).flatten().flatten();
                Axis::around("", points.chain(bounds.copied()))
            }
        };
        LinePanel { title, x, y, lines }
    }

    /// The curves of several runs as one line; `None` if there is none.
    pub(crate) fn line(self, curves: Vec<Curve>, look: Look) -> Option<Line> {
        let curves: Vec<Curve> = curves.into_iter().filter(|curve| !curve.is_empty()).collect();
        let statistic = match self.measure {
            Measure::Mean => mean,
            Measure::Iqm => interquartile_mean,
        };
        if curves.is_empty() {
            return None;
        }
        let Band { points, interval } = summarize(&curves, statistic);
        Some(Line { look, runs: curves.len(), points, band: interval })
    }

    fn curves(self, runs: &[Run], series: &Series) -> Vec<Curve> {
        let curve = |run: &Run| {
            let evaluations = run.evaluations.iter();
            let values = (series.values)(run);
            let point = |(it, value): (&Evaluation, Option<f64>)| Some((self.time(it), value?));
            evaluations.zip(values).filter_map(point).collect()
        };
        runs.iter().map(curve).collect()
    }

    /// When the last run ends.
    pub(crate) fn end(self, groups: &[(Group, Vec<Run>)]) -> f64 {
        let runs = groups.iter().flat_map(|(_, runs)| runs);
        runs.map(|run| self.time(run.last())).fold(0.0, f64::max)
    }

    fn time(self, evaluation: &Evaluation) -> f64 {
        match self.clock {
            Clock::Steps => evaluation.env_steps as f64,
            Clock::Time => evaluation.wall_s / 60.0,
        }
    }
}

/// What a group is called among the groups of its task.
pub(crate) fn name(group: &Group) -> String {
    format!("{} {}", group.method, group.preset)
}
