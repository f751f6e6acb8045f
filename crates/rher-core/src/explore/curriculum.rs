//! Which sub-tasks are mastered, judged by the evaluations of late.

use crate::config::ExplorationConfig;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// A window of evaluation results for every sub-task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curriculum {
    threshold: f32,
    window: usize,
    rates: Vec<VecDeque<f32>>,
}

impl Curriculum {
    /// Nothing is mastered: every window starts with one failure.
    pub fn new(config: &ExplorationConfig, subtasks: usize) -> Self {
        Self {
            threshold: config.success_threshold,
            window: config.window,
            rates: vec![VecDeque::from([0.0]); subtasks],
        }
    }

    /// How many sub-tasks there are.
    #[cfg(feature = "train")]
    pub(crate) fn subtasks(&self) -> usize {
        self.rates.len()
    }

    /// Takes in the success rates of one evaluation; `None` where nothing was evaluated.
    pub fn record(&mut self, success: &[Option<f32>]) {
        for (rates, rate) in self.rates.iter_mut().zip(success) {
            rates.extend(*rate);
            while rates.len() > self.window {
                rates.pop_front();
            }
        }
    }

    /// Mean success rate of a sub-task, counted from 0, over its window.
    pub fn rate(&self, subtask: usize) -> f32 {
        let rates = &self.rates[subtask];
        rates.iter().sum::<f32>() / rates.len() as f32
    }

    /// The paper's g, counted from 0: the last sub-task whose rate is above the threshold, or the
    /// first where none is.
    pub fn guide(&self) -> usize {
        (0..self.rates.len()).rev().find(|&j| self.rate(j) > self.threshold).unwrap_or(0)
    }
}
