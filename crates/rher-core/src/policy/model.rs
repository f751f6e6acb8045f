//! The frozen policy.

use super::info::{Mismatch, PolicyInfo};
use super::run_id::RunId;
use crate::control::Control;
use crate::env::EnvSpec;
use crate::goal::TailSpec;
use crate::input::InputEncoder;
use crate::learner::network::Shape;
use crate::names::Names;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

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
/// let scene = Achieved(Scene::new(Position::new(1.3, 0.7, 0.5), [block]));
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
    pub(super) interface: Arc<Interface>,
}

/// What the numbers of observations and actions are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Interface {
    pub(super) names: Names,
    pub(super) control: Control,
}

impl Policy {
    /// The policy of an actor network with these parameters.
    pub fn new(
        info: PolicyInfo,
        encoder: InputEncoder,
        shape: Shape,
        parameters: Vec<f32>,
    ) -> Self {
        Self { info, encoder, shape, parameters, run: None, interface: Arc::default() }
    }

    /// The same policy, which knows the run that it is of.
    #[must_use]
    pub fn of_run(self, run: RunId) -> Self {
        Self { run: Some(run), ..self }
    }

    /// The same policy, with what another one knows of its numbers.
    #[cfg(feature = "train")]
    pub(crate) fn like(self, other: &Self) -> Self {
        Self { interface: Arc::clone(&other.interface), ..self }
    }

    /// The same policy, which knows what the numbers of environments like `spec` are.
    #[must_use]
    pub fn of_env<const N: usize>(self, spec: &EnvSpec<N>) -> Self {
        let interface = Interface { names: spec.names.clone(), control: spec.control.clone() };
        Self { interface: Arc::new(interface), ..self }
    }

    /// What the numbers that it is given and those that it answers are called; nothing where nobody
    /// knows, and in files of earlier versions.
    pub fn names(&self) -> &Names {
        &self.interface.names
    }

    /// The rate at which it acted in training, and the units and the frame of its numbers; nothing
    /// where nobody knows, and in files of earlier versions.
    pub fn control(&self) -> &Control {
        &self.interface.control
    }

    /// What it was trained for.
    pub fn info(&self) -> &PolicyInfo {
        &self.info
    }

    /// What its goals say of an object beside its position.
    pub fn tail(&self) -> &TailSpec {
        self.encoder.tail()
    }

    /// Whether environments like `spec` are what it was trained for.
    ///
    /// # Errors
    ///
    /// When the number of objects, a dimension, or what goals say of an object differs.
    pub fn check_spec<const N: usize>(&self, spec: &EnvSpec<N>) -> Result<(), Mismatch> {
        self.info.check_spec(spec)?;
        let (ours, theirs) = (self.tail(), &spec.tolerances.tail);
        if ours.means_the_same(theirs) {
            return Ok(());
        }
        Err(Mismatch::new("the goal of an object", ours, theirs))
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
