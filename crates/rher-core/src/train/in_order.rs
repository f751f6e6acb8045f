//! An environment whose objects come in the order that promises most.

use crate::env::{End, Env, EnvError, EnvSpec, Permutation, SignedIndex, Start};
use crate::goal::Achieved;
use crate::input::OrderModel;

/// An environment in which each episode numbers the objects anew, as `model` chooses at its
/// beginning: what is seen, reached and stored of it is what an episode of objects that are given
/// in this order would be.
pub(super) struct InOrder<'a, E, const N: usize> {
    env: &'a mut E,
    model: Option<&'a OrderModel>,
    /// The order of this episode, if it is not the given one.
    order: Option<Permutation<N>>,
    /// An observation of the environment.
    given: Vec<f32>,
}

impl<'a, const N: usize, E: Env<N>> InOrder<'a, E, N> {
    /// Without a model, the objects come as they are given.
    pub(super) fn new(env: &'a mut E, model: Option<&'a OrderModel>) -> Self {
        let given = vec![0.0; env.spec().obs_dim];
        Self { env, model, order: None, given }
    }

    fn reordered(&self, achieved: Achieved<N>, observation: &mut [f32]) -> Achieved<N> {
        match &self.order {
            None => {
                observation.copy_from_slice(&self.given);
                achieved
            }
            Some(Permutation { order, observation: images }) => {
                SignedIndex::apply(images, &self.given, observation);
                Achieved(achieved.0.reordered(order))
            }
        }
    }
}

impl<const N: usize, E: Env<N>> Env<N> for InOrder<'_, E, N> {
    fn spec(&self) -> &EnvSpec<N> {
        self.env.spec()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        let Start { achieved, desired } = self.env.reset(seed, &mut self.given)?;
        self.order = self.model.and_then(|model| model.choose(&achieved, &desired));
        let desired = match &self.order {
            None => desired,
            Some(Permutation { order, .. }) => desired.reordered(order),
        };
        Ok(Start { achieved: self.reordered(achieved, observation), desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        let achieved = self.env.step(action, &mut self.given)?;
        Ok(self.reordered(achieved, observation))
    }

    fn end(&self) -> Option<End> {
        self.env.end()
    }
}
