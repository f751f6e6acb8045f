//! Acts with a policy.

use super::info::{Mismatch, PolicyInfo};
use super::model::Policy;
use crate::env::{EnvSpec, Permutation, SignedIndex};
use crate::episode::ActError;
use crate::goal::{Achieved, Desired, EncodedGoal, Position, Stage};
use crate::learner::infer::Inference;
use std::borrow::Cow;

impl Policy {
    /// An actor for environments like `spec`, with buffers of its own.
    ///
    /// A robot without an [`Env`](crate::Env) states what it provides with [`EnvSpec::new`].
    ///
    /// ```
    /// # use rher_core::{EnvSpec, Policy};
    /// # fn deploy(policy: &Policy) -> Result<(), Box<dyn std::error::Error>> {
    /// // One object, 25 numbers observed, 4 numbers in an action, episodes of 50 steps.
    /// let arm = EnvSpec::<1>::new("arm", 25, 4, 50);
    /// let mut actor = policy.actor(&arm)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    ///
    /// When the policy is for another number of objects or for other dimensions.
    pub fn actor<const N: usize>(&self, spec: &EnvSpec<N>) -> Result<Actor<'_, N>, Mismatch> {
        Actor::new(Cow::Borrowed(self), spec)
    }

    /// An actor that owns its policy, so that a controller can hold it.
    ///
    /// ```
    /// # use rher_core::{Actor, EnvSpec, Mismatch, Policy};
    /// struct Controller {
    ///     actor: Actor<'static, 1>,
    /// }
    ///
    /// impl Controller {
    ///     fn new(policy: Policy) -> Result<Self, Mismatch> {
    ///         Ok(Self { actor: policy.into_actor(&EnvSpec::new("arm", 25, 4, 50))? })
    ///     }
    /// }
    /// ```
    ///
    /// # Errors
    ///
    /// When the policy is for another number of objects or for other dimensions.
    pub fn into_actor<const N: usize>(
        self,
        spec: &EnvSpec<N>,
    ) -> Result<Actor<'static, N>, Mismatch> {
        Actor::new(Cow::Owned(self), spec)
    }
}

/// Acts with a policy in a scene of `N` objects; nothing is allocated from one action to the next.
#[derive(Debug)]
pub struct Actor<'a, const N: usize> {
    policy: Cow<'a, Policy>,
    task: Stage<N>,
    /// The order that the whole task is done in, if it is not the given one.
    order: Option<Permutation<N>>,
    /// An observation in that order.
    reordered: Vec<f32>,
    input: Vec<f32>,
    inference: Inference,
}

impl<'a, const N: usize> Actor<'a, N> {
    fn new(policy: Cow<'a, Policy>, spec: &EnvSpec<N>) -> Result<Self, Mismatch> {
        policy.check_spec(spec)?;
        Ok(Actor {
            task: policy.info.last_stage()?,
            order: None,
            reordered: vec![0.0; policy.info.obs_dim],
            input: vec![0.0; policy.encoder.width()],
            inference: Inference::new(&policy.shape),
            policy,
        })
    }

    /// The policy that it acts with.
    pub fn policy(&self) -> &Policy {
        &self.policy
    }

    /// The stage that ends the task: what a deployed policy acts for.
    pub fn task(&self) -> Stage<N> {
        self.task
    }

    /// Begins an episode of the whole task in this scene, and chooses in which order the objects are
    /// placed, where the policy has learned to choose: from here on [`Actor::act`] keeps to it.
    ///
    /// Without this call, objects are placed in the order in which they are given.
    ///
    /// # Errors
    ///
    /// When a position is not finite; the order of before is then kept.
    pub fn begin(&mut self, achieved: &Achieved<N>, desired: &Desired<N>) -> Result<(), ActError> {
        check_scene(achieved, desired)?;
        let model = self.policy.encoder.order();
        self.order = model.and_then(|model| model.choose(achieved, desired));
        Ok(())
    }

    /// The order that was chosen for this episode; `None` where it is the given one.
    pub fn order(&self) -> Option<&Permutation<N>> {
        self.order.as_ref()
    }

    /// Writes the action of the policy for the sub-task that ends with `stage`: the one network,
    /// given the goal encoded for that stage (eq. 7).
    ///
    /// # Shapes
    ///
    /// `observation`: `[obs_dim]`, raw; `action`: `[action_dim]`, each number in [−1, 1].
    ///
    /// # Errors
    ///
    /// When a length is wrong, or a number that goes in or comes out is not finite. `action` then
    /// holds nothing to be carried out.
    pub fn act(
        &mut self,
        stage: Stage<N>,
        observation: &[f32],
        achieved: &Achieved<N>,
        desired: &Desired<N>,
        action: &mut [f32],
    ) -> Result<(), ActError> {
        let Policy { info, encoder, parameters, .. } = &*self.policy;
        let PolicyInfo { obs_dim, action_dim, .. } = *info;
        check_length("observation", obs_dim, observation.len())?;
        check_length("action", action_dim, action.len())?;
        check_numbers("observation", observation)?;
        check_scene(achieved, desired)?;

        match self.order.as_ref().filter(|_| stage == self.task) {
            None => {
                let goal = EncodedGoal::new(stage, achieved, desired);
                encoder.write(observation, achieved, &goal, &mut self.input);
            }
            Some(Permutation { order, observation: images }) => {
                SignedIndex::apply(images, observation, &mut self.reordered);
                let achieved = Achieved(achieved.0.reordered(order));
                let goal = EncodedGoal::new(stage, &achieved, &desired.reordered(order));
                encoder.write(&self.reordered, &achieved, &goal, &mut self.input);
            }
        }
        self.inference.act(parameters, &self.input, action);
        check_numbers("action", action)
    }
}

fn check_length(field: &'static str, expected: usize, given: usize) -> Result<(), ActError> {
    if expected == given { Ok(()) } else { Err(ActError::Length { field, expected, given }) }
}

fn check_numbers(field: &'static str, numbers: &[f32]) -> Result<(), ActError> {
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(index) => Err(ActError::NotFinite { field, index, value: numbers[index] }),
        None => Ok(()),
    }
}

fn check_scene<const N: usize>(
    achieved: &Achieved<N>,
    desired: &Desired<N>,
) -> Result<(), ActError> {
    check_positions("achieved", achieved.0.places())?;
    check_positions("desired", desired.objects().iter().copied())?;
    check_numbers("achieved tails", achieved.0.tails.all())?;
    check_numbers("desired tails", desired.tails().all())
}

fn check_positions(
    field: &'static str,
    positions: impl Iterator<Item = Position>,
) -> Result<(), ActError> {
    for (place, position) in positions.enumerate() {
        if let Some(axis) = position.iter().position(|number| !number.is_finite()) {
            return Err(ActError::NotFinite {
                field,
                index: 3 * place + axis,
                value: position[axis],
            });
        }
    }
    Ok(())
}
