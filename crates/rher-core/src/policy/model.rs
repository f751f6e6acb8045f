//! The frozen policy.

use super::info::PolicyInfo;
use super::run_id::RunId;
use crate::input::InputEncoder;
use crate::learner::network::Shape;

/// A frozen actor network with everything it needs to act in a scene.
///
/// [`Policy::load`] reads one, [`Policy::actor`] acts with it.
///
/// ```no_run
/// use rher_core::{Achieved, Desired, EnvSpec, Policy, Position, Scene};
///
/// let policy = Policy::load("policy.safetensors".as_ref())?;
/// let arm = EnvSpec::<1>::new("arm", 25, 4, 50);
/// let mut actor = policy.actor(&arm)?;
///
/// // What the robot's sensors say, and where the block should go.
/// let (observation, mut action) = ([0.0; 25], [0.0; 4]);
/// let block = Position::new(1.3, 0.7, 0.42);
/// let scene = Achieved(Scene { gripper: Position::new(1.3, 0.7, 0.5), objects: [block] });
/// let desired = Desired::of_task([Position::new(1.4, 0.8, 0.42)]);
/// actor.act(actor.task(), &observation, &scene, &desired, &mut action)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Policy {
    pub(super) info: PolicyInfo,
    pub(super) encoder: InputEncoder,
    pub(super) shape: Shape,
    pub(super) parameters: Vec<f32>,
    pub(super) run: Option<RunId>,
}

impl Policy {
    /// The policy of an actor network with these parameters.
    pub fn new(
        info: PolicyInfo,
        encoder: InputEncoder,
        shape: Shape,
        parameters: Vec<f32>,
    ) -> Self {
        Self { info, encoder, shape, parameters, run: None }
    }

    /// The same policy, which knows the run that it is of.
    #[must_use]
    pub fn of_run(self, run: RunId) -> Self {
        Self { run: Some(run), ..self }
    }

    /// What it was trained for.
    pub fn info(&self) -> &PolicyInfo {
        &self.info
    }

    /// The run that it is of; `None` where it is of none, and in files of earlier versions.
    pub fn run(&self) -> Option<RunId> {
        self.run
    }

    /// What the network sees.
    #[cfg(feature = "train")]
    pub(crate) fn encoder(&self) -> &InputEncoder {
        &self.encoder
    }
}
