//! Whose turn it is: the order in which the networks see objects that are alike.

use crate::env::{EnvSpec, SignedIndex};
use crate::goal::{Achieved, EncodedGoal, TailSpec, Tolerances};
use serde::{Deserialize, Serialize};
use std::{array, iter};

/// How observations are put in order of turn: the object whose turn it is, those after it, then
/// those before it.
///
/// Then what is to be done next looks the same whichever object it is done to, and whichever
/// sub-task wants it done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Turns {
    /// How near counts as placed, in meters.
    pub(crate) tolerances: Vec<f32>,
    /// For each object, what an observation is when that object comes first.
    pub(crate) observations: Vec<Vec<SignedIndex>>,
}

/// The objects in order of turn when `first` comes first.
pub(crate) fn order<const N: usize>(first: usize) -> [usize; N] {
    array::from_fn(|place| (first + place) % N)
}

impl Turns {
    /// For environments like `spec`; `None` where no two objects are alike.
    pub(crate) fn new<const N: usize>(
        spec: &EnvSpec<N>,
        tolerances: &Tolerances<N>,
    ) -> Option<Self> {
        let exchange = |first| spec.permutations.iter().find(|it| it.order == order(first));
        let others = (1..N).map(|first| exchange(first).map(|it| it.observation.clone()));
        let others = others.collect::<Option<Vec<_>>>().filter(|others| !others.is_empty())?;
        let observations = iter::once(SignedIndex::none(spec.obs_dim)).chain(others).collect();
        Some(Self { tolerances: tolerances.objects.to_vec(), observations })
    }

    /// How many objects take turns.
    pub(crate) fn objects(&self) -> usize {
        self.observations.len()
    }

    /// Whether it fits observations of this width.
    pub(crate) fn fits(&self, observation: usize, objects: usize) -> bool {
        let fits = |images: &Vec<SignedIndex>| {
            images.len() == observation && images.iter().all(|image| image.from < observation)
        };
        self.tolerances.len() == objects
            && self.observations.len() == objects
            && self.observations.iter().all(fits)
    }

    /// The object whose turn it is: the first that `goal` wants somewhere else than where it is
    /// `now`, and otherwise the last that the sub-task is about.
    pub(crate) fn first<const N: usize>(
        &self,
        now: &Achieved<N>,
        goal: &EncodedGoal<N>,
        tail: &TailSpec,
    ) -> usize {
        let scene = &now.0;
        let earlier = self.tolerances.iter().enumerate().take(goal.last());
        let mut misplaced = earlier.map(|(object, tolerance)| {
            let reached = (&scene.objects[object], scene.tails.of_object(object));
            goal.objects()[object].is_some_and(|wanted| {
                !tail.is_there(*tolerance, (&wanted, goal.tail(object)), reached)
            })
        });
        misplaced.position(|misplaced| misplaced).unwrap_or(goal.last())
    }

    /// An observation as it is when `first` comes first, number by number.
    pub(crate) fn observation<'a>(
        &'a self,
        first: usize,
        observation: &'a [f32],
    ) -> impl Iterator<Item = f32> + 'a {
        self.observations[first].iter().map(|image| image.of(observation))
    }
}
