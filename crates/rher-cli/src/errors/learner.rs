//! Training, checkpoints and policies.

use super::report::{Explain, Report};
use super::runs::and_there;
use crate::exit_code::Status;
use rher_core::OnnxError;
use rher_core::episode::RolloutError;
use rher_core::evaluate::EvaluateError;
use rher_core::files::{Access, FileError};
use rher_core::learner::engines::EngineError;
use rher_core::learner::simd::SimdError;
use rher_core::policy::PolicyError;
use rher_core::train::checkpoint::CheckpointError;
use rher_core::train::{PretrainedError, TrainError, Unfit};
use std::io;

impl Explain for TrainError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Checkpoint(error) => error.report(),
            Self::Pretrained(error) => error.report(),
            Self::Rollout { source, .. } => source.report(),
            Self::Evaluate { source, .. } => source.report(),
            Self::NotFinite { .. } => Some(Report::new(
                Status::NotFinite,
                "the state before this update was saved; smaller values of \
                 `agent.actor_learning_rate` and `agent.critic_learning_rate` help against \
                 divergence",
            )),
            Self::Config(_) | Self::Memory(_) | Self::Engine(_) => {
                Some(Report::plain(Status::Usage))
            }
            _ => None,
        }
    }
}

impl Explain for EngineError {
    fn report(&self) -> Option<Report> {
        Some(Report::plain(Status::Usage))
    }
}

impl Explain for SimdError {
    fn report(&self) -> Option<Report> {
        Some(Report::plain(Status::Usage))
    }
}

impl Explain for PretrainedError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::NoCheckpoint { .. } => {
                let hint = and_there("give a folder that `rher train` made");
                Some(Report::new(Status::RunFolder, hint))
            }
            Self::Checkpoint(CheckpointError::Version { .. }) => Some(Report::new(
                Status::Damaged,
                "train the run to start from again, with this version of `rher`",
            )),
            Self::Checkpoint(error) => error.report(),
            Self::Unfit { reason: Unfit::OtherSetting { key, found, .. }, .. } => {
                Some(Report::new(Status::Usage, format!("`--set {key}={found}` makes them fit")))
            }
            _ => Some(Report::plain(Status::Usage)),
        }
    }
}

impl Explain for EvaluateError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Rollout(error) => error.report(),
            Self::Mismatch(_) => {
                Some(Report::new(Status::Damaged, "give a policy that was trained for this task"))
            }
            _ => None,
        }
    }
}

impl Explain for RolloutError {
    fn report(&self) -> Option<Report> {
        Some(match self {
            Self::NotFinite { .. } => Report::new(
                Status::NotFinite,
                "the environment is at fault, not the learner; the seed above repeats its episode",
            ),
            Self::Act { .. } => Report::plain(Status::NotFinite),
            _ => Report::plain(Status::Environment),
        })
    }
}

impl Explain for CheckpointError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Damaged { path, .. } => {
                let hint = if path.extension().is_some_and(|extension| extension == "ckpt") {
                    "nothing was changed; to resume from an earlier checkpoint, rename it to \
                     `current.ckpt`; the policy file still works"
                } else {
                    "nothing was changed; the policy file still works"
                };
                Some(Report::new(Status::Damaged, hint))
            }
            Self::Version { .. } => Some(Report::new(
                Status::Damaged,
                "resume the run with the version of `rher` that made it; its policy still works",
            )),
            Self::Missing { .. } => {
                Some(Report::new(Status::RunFolder, "`rher train <TASK> --out DIR` starts a run"))
            }
            Self::Policy(error) => error.report(),
            Self::Mismatch { .. } => Some(Report::plain(Status::Damaged)),
            Self::File(error) => error.report(),
            _ => None,
        }
    }
}

impl Explain for PolicyError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Malformed { .. } => Some(Report::new(
                Status::Damaged,
                "expected the file `policy.safetensors` of a run folder",
            )),
            Self::File(FileError { access: Access::Read, source, .. })
                if source.kind() == io::ErrorKind::NotFound =>
            {
                let hint = "give a run folder that has a policy, a policy file, or the name of a task, whose \
                            policy ships with the program";
                Some(Report::new(Status::RunFolder, and_there(hint)))
            }
            Self::File(error) => error.report(),
            _ => None,
        }
    }
}

impl Explain for OnnxError {
    fn report(&self) -> Option<Report> {
        match self {
            Self::Policy(error) => error.report(),
            Self::File(error) => error.report(),
            Self::Name { .. } => Some(Report::plain(Status::Usage)),
            _ => None,
        }
    }
}
