//! How a run ends, and why it could not go on.

use super::checkpoint::CheckpointError;
use super::memory::MemoryError;
use super::pretrained::PretrainedError;
use crate::config::ConfigError;
use crate::env::SpecError;
use crate::episode::RolloutError;
use crate::evaluate::EvaluateError;
use crate::event::ObserverError;
use crate::learner::engine::NotFinite;
use crate::learner::engines::EngineError;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// The success rate of two consecutive evaluations was at least `until`.
    Solved,
    /// All environment steps were taken.
    StepsSpent,
    /// It was asked to stop.
    Stopped,
}

/// A run could not go on; what was saved before is untouched.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// A setting is outside its range.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The run needs more memory than there is.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The engine that the settings name is not part of this build, or `RHER_SIMD` names
    /// instructions that the machine does not have.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The specification of the environments is wrong.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The environments differ.
    #[error(
        "environment {index} has another specification than environment 0; every environment of a \
         run must have the same"
    )]
    DifferentEnvs {
        /// The first that differs, counted from 0.
        index: usize,
    },
    /// The settings were made for another number of objects.
    #[error(
        "the settings are for {config} objects and the environments have {envs}; make them with \
         `Preset::config(task, {envs})`"
    )]
    OtherObjects {
        /// Objects that the preset was asked for.
        config: usize,
        /// Objects in the environments.
        envs: usize,
    },
    /// Fewer environments than the settings ask for.
    #[error("{given} environments were given, expected at least `envs` = {expected}")]
    TooFewEnvs {
        /// How many were given.
        given: usize,
        /// How many are needed.
        expected: usize,
    },
    /// The run cannot start from the one that it should start from.
    #[error(transparent)]
    Pretrained(#[from] PretrainedError),
    /// The threads could not be started.
    #[error("cannot start {workers} threads")]
    Threads {
        /// How many were asked for.
        workers: usize,
        /// What the system said.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// An environment failed in training.
    #[error("episode {episode}")]
    Rollout {
        /// Number of the training episode.
        episode: u64,
        /// What went wrong.
        source: RolloutError,
    },
    /// An environment failed in evaluation.
    #[error("evaluation after episode {episode}")]
    Evaluate {
        /// Training episodes before it.
        episode: u64,
        /// What went wrong.
        source: EvaluateError,
    },
    /// The learner diverged; the state before the update was saved.
    #[error(
        "update {update}, after {env_steps} environment steps, diverged; its batch has seed {seed}, \
         count {update}"
    )]
    NotFinite {
        /// Number of the update, which is the count of its batch's random stream.
        update: u64,
        /// Environment steps before it.
        env_steps: u64,
        /// Seed of the run.
        seed: u64,
        /// Which gradient it is.
        source: NotFinite,
    },
    /// The checkpoint could not be written or read.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// An observer failed.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}
