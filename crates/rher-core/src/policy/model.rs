//! The frozen policy.

use super::info::PolicyInfo;
use crate::input::InputEncoder;
use crate::learner::network::Shape;

/// A frozen actor network with everything it needs to act in a scene.
///
/// [`Policy::load`] reads one, [`Policy::actor`] acts with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Policy {
    pub(super) info: PolicyInfo,
    pub(super) encoder: InputEncoder,
    pub(super) shape: Shape,
    pub(super) parameters: Vec<f32>,
}

impl Policy {
    /// The policy of an actor network with these parameters.
    pub fn new(
        info: PolicyInfo,
        encoder: InputEncoder,
        shape: Shape,
        parameters: Vec<f32>,
    ) -> Self {
        Self { info, encoder, shape, parameters }
    }

    /// What it was trained for.
    pub fn info(&self) -> &PolicyInfo {
        &self.info
    }

    /// What the network sees.
    #[cfg(feature = "train")]
    pub(crate) fn encoder(&self) -> &InputEncoder {
        &self.encoder
    }
}
