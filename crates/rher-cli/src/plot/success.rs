//! Success of a task and of its sub-tasks, beside the curves that the authors published.

use super::chart::{Line, Panel};
use super::curves::{Curve, summarize};
use super::looks::{self, Looks};
use super::published;
use super::statistics::mean;
use super::view::{Clock, Quantity, Series, Unit, View};
use rher_envs::Task;
use rher_runs::{Evaluation, Group, Run};

/// How far a published curve matters: until its mean first is there.
const SOLVED: f64 = 0.95;

impl View {
    /// The success of one task.
    pub(crate) fn success(self, groups: &[(Group, Vec<Run>)], looks: &Looks) -> Panel {
        let task = &groups[0].0.task;
        let end = self.end_beside_published(groups);
        let whole = Series {
            look: looks::named(""),
            values: Box::new(|run| {
                run.evaluations.iter().map(|evaluation| Some(evaluation.success_final)).collect()
            }),
        };
        let quantity = Quantity { title: String::new(), unit: Unit::Share, series: vec![whole] };
        let ours = self.panels(&quantity, groups, looks, end);
        let published =
            if self.clock == Clock::Steps { self.published(task, end) } else { Vec::new() };
        let ours = ours.iter().flat_map(Panel::lines).cloned();
        let lines = published.into_iter().chain(ours).collect();
        Panel::Lines(self.shares(format!("{task}: success"), lines, end))
    }

    /// The success of each sub-task before the last, for each group that trains them.
    pub(crate) fn subtasks(self, groups: &[(Group, Vec<Run>)], looks: &Looks) -> Vec<Panel> {
        let task = &groups[0].0.task;
        let count = groups.iter().map(|(_, runs)| runs[0].last().success.len()).max().unwrap_or(1);
        let series = (0..count - 1).map(|index| {
            let name = subtask_name(task, index);
            let value = move |evaluation: &Evaluation| {
                let before_the_last = index + 1 < evaluation.success.len();
                before_the_last.then(|| evaluation.success[index]).flatten()
            };
            let values = move |run: &Run| run.evaluations.iter().map(value).collect();
            Series { look: looks::subtask(&name, index), values: Box::new(values) }
        });
        let title = format!("{task}: sub-tasks");
        let series: Vec<Series> = series.collect();
        let end = self.end_beside_published(groups);
        match count {
            0 | 1 => Vec::new(),
            // Of a single one, groups can be compared.
            2 => {
                let title = format!("{task}: {}", series[0].look.name);
                let quantity = Quantity { title, unit: Unit::Share, series };
                self.panels(&quantity, groups, looks, end)
            }
            _ => self.panels(&Quantity { title, unit: Unit::Share, series }, groups, looks, end),
        }
    }

    /// Where the horizontal axis ends: with the runs, or where the published ones are done.
    fn end_beside_published(self, groups: &[(Group, Vec<Run>)]) -> f64 {
        let end = self.end(groups);
        let published = published::curves(&groups[0].0.task, "rher");
        if self.clock == Clock::Time || published.is_empty() {
            return end;
        }
        let points = summarize(&published, mean).points;
        let solved = points.into_iter().find(|point| point.1 >= SOLVED);
        solved.map_or(end, |(steps, _)| end.max(steps))
    }

    /// The curves that the authors published, as far as the axis goes.
    fn published(self, task: &str, end: f64) -> Vec<Line> {
        let line = |(method, look)| {
            let curves = published::curves(task, method).into_iter();
            let until_end =
                |curve: Curve| curve.into_iter().filter(|point| point.0 <= end).collect();
            self.line(curves.map(until_end).collect(), look)
        };
        looks::published().filter_map(line).collect()
    }
}

/// What a sub-task is called; also one of a task that is not known here.
pub(super) fn subtask_name(task: &str, index: usize) -> String {
    let known = task.parse().map_or_else(|_| Vec::new(), Task::subtasks);
    known.get(index).cloned().unwrap_or_else(|| format!("sub-task {}", index + 1))
}
