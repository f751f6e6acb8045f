//! Which rows of an update are whose.

use crate::batch::Batch;
use crate::explore::Curriculum;
use crate::goal::Stage;
use std::ops::Range;

/// The rows of one update, some for each of its sub-tasks.
pub(super) struct SubtaskBatch<const N: usize> {
    pub(super) stages: Vec<Stage<N>>,
    pub(super) batch: Batch,
}

impl<const N: usize> SubtaskBatch<N> {
    /// Which rows are whose: `focus` of them by how often a sub-task still fails, the others
    /// evenly.
    pub(super) fn rows(&self, focus: f32, curriculum: &Curriculum) -> Vec<Range<usize>> {
        let failing = |stage: &Stage<N>| 1.0 - curriculum.rate(stage.index());
        let failures: f32 = self.stages.iter().map(failing).sum();
        let focus = if failures > 0.0 { focus } else { 0.0 };
        let even = (1.0 - focus) / self.stages.len() as f32;
        let of_failures = focus / failures.max(f32::MIN_POSITIVE);
        let (mut share, mut start) = (0.0, 0);
        let mut rows = Vec::with_capacity(self.stages.len());
        for stage in &self.stages {
            share += even + of_failures * failing(stage);
            let end = (share * self.batch.rows() as f32).round() as usize;
            rows.push(start..end);
            start = end;
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Preset;

    #[test]
    fn sub_tasks_that_fail_get_more_rows_and_all_get_some() {
        let stages: Vec<Stage<2>> = Stage::all().collect();
        let batch = SubtaskBatch { stages, batch: Batch::zeros(400, 1, 1) };
        let mut curriculum = Curriculum::new(&Preset::Fast.config("rows", 2).exploration, 4);
        let even = vec![0..100, 100..200, 200..300, 300..400];
        assert_eq!(batch.rows(0.5, &curriculum), even, "all fail alike");
        for _ in 0..10 {
            curriculum.record(&[Some(1.0), Some(1.0), Some(0.75), Some(0.25)]);
        }
        assert_eq!(batch.rows(0.0, &curriculum), even);
        assert_eq!(batch.rows(0.5, &curriculum), [0..50, 50..100, 100..200, 200..400]);
        for _ in 0..10 {
            curriculum.record(&[Some(1.0); 4]);
        }
        assert_eq!(batch.rows(0.5, &curriculum), even, "nothing fails");
    }
}
