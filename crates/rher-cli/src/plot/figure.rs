//! Learning curves of several tasks as one picture.

use super::chart::{Drawing, Panel, Sheet};
use super::looks::Looks;
use super::view::{Measure, View, name};
use rher_runs::{Group, Run};
use std::num::NonZeroUsize;

/// What a picture of learning curves shows.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    pub(crate) view: View,
    pub(crate) title: Option<String>,
    /// Panels beside each other, if that was chosen.
    pub(crate) columns: Option<NonZeroUsize>,
    pub(crate) subtasks: bool,
    /// Runs whose curves are not at their end.
    pub(crate) running: usize,
}

/// Panels beside each other that are still wide enough to be read.
const COLUMNS: usize = 3;

impl Figure {
    /// For each task its success, and that of its sub-tasks. A task with several panels begins a row.
    pub(crate) fn draw(&self, groups: &[(Group, Vec<Run>)]) -> Drawing {
        let looks = Looks::of(groups.iter().map(|(group, _)| name(group)));
        let tasks: Vec<Vec<Panel>> =
            by_task(groups).map(|groups| self.panels(groups, &looks)).collect();
        let columns = self.columns.map_or(COLUMNS, NonZeroUsize::get);
        let cut = |panels: Vec<Panel>| panels.chunks(columns).map(<[Panel]>::to_vec).collect();
        let rows: Vec<Vec<Panel>> = if tasks.iter().all(|panels| panels.len() == 1) {
            cut(tasks.concat())
        } else {
            tasks.into_iter().flat_map(|panels| -> Vec<Vec<Panel>> { cut(panels) }).collect()
        };
        Sheet { title: self.title.clone(), rows, caption: self.caption() }.draw()
    }

    fn panels(&self, groups: &[(Group, Vec<Run>)], looks: &Looks) -> Vec<Panel> {
        let mut panels = vec![self.view.success(groups, looks)];
        if self.subtasks {
            panels.extend(self.view.subtasks(groups, looks));
        }
        panels
    }

    fn caption(&self) -> String {
        let running = match self.running {
            0 => String::new(),
            1 => " One run is still running.".to_owned(),
            several => format!(" {several} runs are still running."),
        };
        self.view.measure.caption() + &running
    }
}

impl Measure {
    /// What lines and bands are.
    pub(crate) fn caption(self) -> String {
        let line = match self {
            Self::Mean => "mean",
            Self::Iqm => "interquartile mean",
        };
        format!(
            "Line: {line} of n runs; a run that has ended keeps its last value. \
             Band: 95 % bootstrap interval over runs."
        )
    }
}

/// Groups of the same task together.
pub(crate) fn by_task(groups: &[(Group, Vec<Run>)]) -> impl Iterator<Item = &[(Group, Vec<Run>)]> {
    groups.chunk_by(|(a, _), (b, _)| a.task == b.task)
}
