//! Learning curves: a row of panels for each task.

use super::chart::{Axis, Drawing, Ink, Line, Panel};
use super::curves::{Band, Curve, summarize};
use super::published;
use super::statistics::{interquartile_mean, mean};
use clap::ValueEnum;
use rher_envs::Task;
use rher_runs::{Evaluation, Group, Run};

/// Colors that differ for every kind of color vision, after Okabe and Ito.
const INKS: [Ink; 6] = [
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xe6, 0x9f, 0x00],
    [0x56, 0xb4, 0xe9],
];

/// Of the published curves.
const PUBLISHED: [(&str, Ink); 2] = [("rher", [0x55, 0x55, 0x55]), ("her", [0xaa, 0xaa, 0xaa])];

/// How far a published curve matters: until its mean first is there.
const SOLVED: f64 = 0.95;

/// Width of the panel of a task, of that of each sub-task, and height of both, in pixels.
const TASK_WIDTH: f32 = 460.0;
const SUBTASK_WIDTH: f32 = 250.0;
const HEIGHT: f32 = 260.0;

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

/// What curves show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figure {
    pub(crate) clock: Clock,
    pub(crate) measure: Measure,
}

impl Figure {
    /// For each task the success of the whole task, then that of each sub-task before the last.
    pub(crate) fn draw(self, groups: &[(Group, Vec<Run>)]) -> Drawing {
        let mut names: Vec<String> = Vec::new();
        for (group, _) in groups {
            if !names.contains(&name(group)) {
                names.push(name(group));
            }
        }
        let same_task = |a: &(Group, Vec<Run>), b: &(Group, Vec<Run>)| a.0.task == b.0.task;
        let rows: Vec<Vec<Panel>> =
            groups.chunk_by(same_task).map(|groups| self.row(groups, &names)).collect();
        let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
        let widths: Vec<f32> =
            std::iter::once(TASK_WIDTH).chain(vec![SUBTASK_WIDTH; columns - 1]).collect();
        Drawing::of(&rows, &widths, HEIGHT)
    }

    /// The panels of one task.
    fn row(self, groups: &[(Group, Vec<Run>)], names: &[String]) -> Vec<Panel> {
        let task = &groups[0].0.task;
        let end = self.end(task, groups);
        let subtasks = groups.iter().map(|(_, runs)| runs[0].last().success.len());
        let subtasks = subtasks.max().unwrap_or(1);
        let whole = self.panel(format!("{task}: success"), None, groups, names, end);
        let known = task.parse().map_or_else(|_| Vec::new(), Task::subtasks);
        let before = (0..subtasks - 1).map(|subtask| {
            let title = known.get(subtask).cloned();
            let title = title.unwrap_or_else(|| format!("sub-task {}", subtask + 1));
            self.panel(title, Some(subtask), groups, names, end)
        });
        std::iter::once(whole).chain(before.filter(|panel| !panel.lines.is_empty())).collect()
    }

    fn panel(
        self,
        title: String,
        subtask: Option<usize>,
        groups: &[(Group, Vec<Run>)],
        names: &[String],
        end: f64,
    ) -> Panel {
        let mut lines = Vec::new();
        if subtask.is_none() && self.clock == Clock::Steps {
            lines.extend(self.published(&groups[0].0.task, end));
        }
        for (group, runs) in groups {
            let curves = runs.iter().filter_map(|run| self.curve(run, subtask)).collect();
            let index = names.iter().position(|known| *known == name(group)).unwrap_or(0);
            lines.extend(self.line(curves, name(group), INKS[index % INKS.len()], false));
        }
        let axis = match self.clock {
            Clock::Steps => Axis { name: "environment steps", end, show: steps },
            Clock::Time => Axis { name: "wall clock, minutes", end, show: plain },
        };
        Panel { title, axis, lines }
    }

    /// Where the horizontal axis ends: with the runs, or where the published ones are done.
    fn end(self, task: &str, groups: &[(Group, Vec<Run>)]) -> f64 {
        let runs = groups.iter().flat_map(|(_, runs)| runs);
        let end = runs.map(|run| self.time(run.last())).fold(0.0, f64::max);
        let published = published::curves(task, "rher");
        if self.clock == Clock::Time || published.is_empty() {
            return end;
        }
        let points = summarize(&published, mean).points;
        let solved = points.into_iter().find(|point| point.1 >= SOLVED);
        solved.map_or(end, |(steps, _)| end.max(steps))
    }

    /// The curves that the authors published, as far as the axis goes.
    fn published(self, task: &str, end: f64) -> Vec<Line> {
        let line = |(method, ink): (&str, Ink)| {
            let curves = published::curves(task, method).into_iter();
            let until_end =
                |curve: Curve| curve.into_iter().filter(|point| point.0 <= end).collect();
            let curves = curves.map(until_end).collect();
            self.line(curves, format!("{method}, published"), ink, true)
        };
        PUBLISHED.into_iter().filter_map(line).collect()
    }

    fn line(self, curves: Vec<Curve>, name: String, ink: Ink, dashed: bool) -> Option<Line> {
        let curves: Vec<Curve> = curves.into_iter().filter(|curve| !curve.is_empty()).collect();
        let statistic = match self.measure {
            Measure::Mean => mean,
            Measure::Iqm => interquartile_mean,
        };
        if curves.is_empty() {
            return None;
        }
        let Band { points, interval } = summarize(&curves, statistic);
        Some(Line { name, ink, dashed, points, band: interval })
    }

    /// The success of a run, or of one of its sub-tasks if it has that and trains it.
    fn curve(self, run: &Run, subtask: Option<usize>) -> Option<Curve> {
        let success = |evaluation: &Evaluation| match subtask {
            None => Some(evaluation.success_final),
            Some(subtask) if subtask + 1 < evaluation.success.len() => evaluation.success[subtask],
            Some(_) => None,
        };
        let points = run.evaluations.iter();
        points.map(|evaluation| Some((self.time(evaluation), success(evaluation)?))).collect()
    }

    fn time(self, evaluation: &Evaluation) -> f64 {
        match self.clock {
            Clock::Steps => evaluation.env_steps as f64,
            Clock::Time => evaluation.wall_s / 60.0,
        }
    }
}

fn name(group: &Group) -> String {
    format!("{} {}", group.method, group.preset)
}

/// `20k` for 20,000.
fn steps(number: f64) -> String {
    if number >= 1e6 {
        plain(number / 1e6) + "M"
    } else if number >= 1e3 {
        plain(number / 1e3) + "k"
    } else {
        plain(number)
    }
}

/// Without the digits that rounding leaves behind.
fn plain(number: f64) -> String {
    ((number * 1e6).round() / 1e6).to_string()
}
