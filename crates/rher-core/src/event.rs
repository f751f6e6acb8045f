//! What happens in a run, for its observers.

use crate::explore::ActionLog;
use serde::{Deserialize, Serialize};

/// Something that happened in a run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A training episode was played that the observer [wants](Observer::wants).
    Explored(Box<ActionLog>),
    /// Training episodes ended and the updates after them were made.
    Progress(Progress),
    /// An evaluation ended.
    Evaluated(Box<Metrics>),
    /// A checkpoint is about to be written; an error of the observer prevents it.
    Saving,
    /// A checkpoint is on disk.
    Saved,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Environment steps of training so far.
    pub env_steps: u64,
    /// Training episodes so far.
    pub episodes: u64,
    /// Updates of the critics so far.
    pub updates: u64,
}

/// One line of `metrics.jsonl`: the state of a run at an evaluation.
///
/// Means and shares are over the training since the evaluation before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Environment steps of training so far.
    pub env_steps: u64,
    /// Training episodes so far.
    pub episodes: u64,
    /// Updates of the critics so far.
    pub updates: u64,
    /// Seconds of the wall clock so far, resumed parts added up.
    pub wall_s: f64,
    /// Success rate of every sub-task, the first one first; one that is not trained is `None`.
    pub success: Vec<Option<f32>>,
    /// Success rate of the last sub-task: the task itself.
    pub success_final: f32,
    /// The paper's g, counted from 1: the sub-task that guides exploration.
    pub guide: usize,
    /// Mean distance of the objects to their targets at the end of the final evaluation, meters.
    pub final_distance: f32,
    /// Share of training episodes that ended with the task solved.
    pub train_success: f32,
    /// Share of training steps in which the guide, the learner or chance acted.
    pub acted: SourceShares,
    /// For each object, share of training episodes that moved it by more than a centimeter.
    pub moved: Vec<f32>,
    /// Share of update batches in which every reward was the same, by sub-task (the paper's NNSR).
    pub single_reward: Vec<Option<f32>>,
    /// Mean critic loss (eq. 1).
    pub critic_loss: f32,
    /// Mean actor loss (eq. 2).
    pub actor_loss: f32,
    /// Mean of Q₁ over batches.
    pub q_mean: f32,
    /// Smallest Q₁ in any batch.
    pub q_min: f32,
    /// Largest Q₁ in any batch.
    pub q_max: f32,
    /// Mean L2 norm of the critics' gradient.
    pub critic_gradient: f32,
    /// Mean L2 norm of the actor's gradient.
    pub actor_gradient: f32,
    /// Where the wall clock's seconds went.
    pub time: Seconds,
}

/// Who acted, as shares that add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SourceShares {
    /// The guide's policy.
    pub guide: f32,
    /// The learner's policy.
    pub learner: f32,
    /// A uniform draw.
    pub random: f32,
}

/// Seconds of the wall clock so far, by what they were spent on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Seconds {
    /// Stepping environments in training.
    pub environment: f64,
    /// Choosing actions in training.
    pub inference: f64,
    /// Storing episodes, and drawing and relabeling batches of them.
    pub relabel: f64,
    /// Updating the networks.
    pub update: f64,
    /// Evaluating.
    pub evaluate: f64,
    /// Writing checkpoints.
    pub save: f64,
}

/// An observer could not do its work, and the run should end.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ObserverError(#[from] pub Box<dyn std::error::Error + Send + Sync>);

/// Is told what happens in a run; never influences it.
///
/// ```
/// use rher_core::{Event, Observer, ObserverError};
///
/// /// Keeps the success rate of every evaluation.
/// struct Curve(Vec<f32>);
///
/// impl Observer for Curve {
///     fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
///         if let Event::Evaluated(metrics) = event {
///             self.0.push(metrics.success_final);
///         }
///         Ok(())
///     }
/// }
/// # let _ = Curve(Vec::new());
/// ```
pub trait Observer {
    /// Takes note of `event`.
    fn on(&mut self, event: &Event) -> Result<(), ObserverError>;

    /// Whether it wants to be told of the training episode with this number, counted from 0.
    fn wants(&self, _episode: u64) -> bool {
        false
    }
}

/// A closure is an observer: `&mut |_: &Event| Ok(())` watches nothing.
impl<F: FnMut(&Event) -> Result<(), ObserverError>> Observer for F {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        self(event)
    }
}
