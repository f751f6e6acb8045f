//! What a program needs of an environment besides acting in it: to see it, to begin it somewhere, to
//! keep its state.

use crate::layout::{Chosen, Layout};
use crate::observation::Places;
use crate::options::Options;
use crate::thing::Thing;
use rher_core::env::{Env, EnvError, Start};
use rher_core::goal::{Desired, Position};
use std::any::Any;

/// An environment that can be seen, and whose state can be chosen, kept and returned to.
///
/// What it has no answer to, an environment that is no [`Simulation`](crate::Simulation) leaves out: it cannot be drawn
/// then, or not be saved in mid-episode.
pub trait Simulated<const N: usize>: Env<N> + 'static {
    /// Starts an episode from a chosen layout and writes its first observation.
    ///
    /// What is randomized is that of seed 0.
    fn arrange(
        &mut self,
        _layout: Layout<N>,
        _observation: &mut [f32],
    ) -> Result<Start<N>, EnvError> {
        let name = &self.spec().name;
        Err(EnvError::new(format!("the environment `{name}` cannot start from a chosen layout")))
    }

    /// Starts the episode of a seed, with the part of its layout that is chosen instead of drawn, and
    /// writes its first observation.
    ///
    /// # Errors
    ///
    /// [`ChosenError`](crate::ChosenError) if what is chosen has the wrong width, is not finite, or
    /// is where the task cannot put an object.
    fn reset_with(
        &mut self,
        seed: u64,
        chosen: &Chosen,
        observation: &mut [f32],
    ) -> Result<Start<N>, EnvError> {
        if *chosen == Chosen::default() {
            return self.reset(seed, observation);
        }
        let name = &self.spec().name;
        Err(EnvError::new(format!("the environment `{name}` cannot start from a chosen layout")))
    }

    /// Everything that an episode's future depends on, besides its actions.
    fn snapshot(&self) -> Option<Snapshot> {
        None
    }

    /// Goes on from a snapshot, bitwise as the environment did that it was taken from.
    fn return_to(&mut self, _snapshot: &Snapshot) -> Result<(), SnapshotError> {
        Err(SnapshotError::OtherTask)
    }

    /// What was set when it was made.
    fn options(&self) -> &Options {
        Options::none()
    }

    /// Where in an observation the gripper's and the objects' positions are.
    fn places(&self) -> Places<N> {
        Places::unknown()
    }

    /// Whether actions can bring the gripper, as observations and goals have it, near enough to
    /// `place` that it counts as there, whatever is in the way.
    fn can_reach(&self, _place: &Position) -> bool {
        true
    }

    /// Everything that can be seen but the floor at height 0, where it really is, whatever sensors
    /// tell.
    fn things(&self) -> Vec<Thing> {
        Vec::new()
    }

    /// Marks of where the objects should go, the first object's first, named `goal_1` and so on.
    fn goals(&self, desired: &Desired<N>) -> Vec<Thing> {
        let tolerances = self.spec().tolerances.objects;
        let goals = desired.objects().iter().zip(tolerances).enumerate();
        goals.map(|(index, (place, tolerance))| Thing::goal(index, *place, tolerance)).collect()
    }
}

impl<const N: usize> Simulated<N> for Box<dyn Simulated<N>> {
    fn arrange(
        &mut self,
        layout: Layout<N>,
        observation: &mut [f32],
    ) -> Result<Start<N>, EnvError> {
        (**self).arrange(layout, observation)
    }

    fn reset_with(
        &mut self,
        seed: u64,
        chosen: &Chosen,
        observation: &mut [f32],
    ) -> Result<Start<N>, EnvError> {
        (**self).reset_with(seed, chosen, observation)
    }

    fn snapshot(&self) -> Option<Snapshot> {
        (**self).snapshot()
    }

    fn return_to(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        (**self).return_to(snapshot)
    }

    fn options(&self) -> &Options {
        (**self).options()
    }

    fn places(&self) -> Places<N> {
        (**self).places()
    }

    fn can_reach(&self, place: &Position) -> bool {
        (**self).can_reach(place)
    }

    fn things(&self) -> Vec<Thing> {
        (**self).things()
    }

    fn goals(&self, desired: &Desired<N>) -> Vec<Thing> {
        (**self).goals(desired)
    }
}

/// The state of an environment, whatever its task.
pub struct Snapshot(Box<dyn Any + Send>);

impl Snapshot {
    /// Of what an environment knows itself by.
    pub fn new(state: impl Send + 'static) -> Self {
        Self(Box::new(state))
    }

    /// What it was made of, if that is a `T`.
    pub fn get<T: 'static>(&self) -> Option<&T> {
        self.0.downcast_ref()
    }
}

/// An environment cannot return to a snapshot.
#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    /// It is of another task.
    #[error("the snapshot is of an environment of another task")]
    OtherTask,
    /// It is of an environment that was made with other options.
    #[error("the snapshot is of an environment with {found:?}, expected {expected:?}")]
    OtherOptions {
        /// Options of the environment.
        expected: Box<Options>,
        /// Options of the snapshot.
        found: Box<Options>,
    },
}
