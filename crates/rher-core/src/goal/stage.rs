//! The relay: `2 N` stages, and sub-tasks that end at one of them.

use super::position::is_within;
use super::{Achieved, Desired, Tolerances};
use serde::{Deserialize, Serialize};

/// Which half of an object's share of the relay a stage is.
///
/// ```
/// use rher_core::{Leg, Stage};
///
/// let legs: Vec<Leg> = Stage::<1>::all().map(Stage::leg).collect();
/// assert_eq!(legs, [Leg::Reach, Leg::Place]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Leg {
    /// Bring the gripper to the object.
    Reach,
    /// Bring the object to its target.
    Place,
}

impl Leg {
    /// The leg of the sub-task at a place in the relay, counted from 0.
    pub fn of_subtask(index: usize) -> Self {
        if index.is_multiple_of(2) { Self::Reach } else { Self::Place }
    }
}

/// One of the `2 N` stages ζ of a relay over `N` objects, in relay order.
///
/// A stage also names the sub-task that ends with it (eq. 5): ψⱼ is all stages up to ζⱼ, and its
/// policy is the one shared network, fed with the goal encoded for stage j (eq. 7).
///
/// ```
/// use rher_core::Stage;
///
/// // Two objects, four stages; the third is to reach the second object.
/// let stages: Vec<Stage<2>> = Stage::all().collect();
/// assert_eq!(stages.len(), 4);
/// assert_eq!(stages[2].object(), 1);
/// assert_eq!(Stage::from_index(2), Some(stages[2]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage<const N: usize> {
    object: usize,
    leg: Leg,
}

impl<const N: usize> Stage<N> {
    /// How many stages there are.
    pub const COUNT: usize = 2 * N;

    /// Reach the first object.
    pub const FIRST: Self = {
        assert!(N > 0, "a relay needs at least one object");
        Self { object: 0, leg: Leg::Reach }
    };

    /// The stage at a place in the relay, counted from 0; `None` past the last.
    pub fn from_index(index: usize) -> Option<Self> {
        let leg = Leg::of_subtask(index);
        (index < Self::COUNT).then_some(Self { object: index / 2, leg })
    }

    /// Placing an object.
    ///
    /// # Panics
    ///
    /// If there is no such object.
    pub fn place(object: usize) -> Self {
        assert!(object < N, "object {object} of {N}");
        Self { object, leg: Leg::Place }
    }

    /// Every stage, in relay order.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> {
        (0..Self::COUNT).filter_map(Self::from_index)
    }

    /// Place in the relay, counted from 0: the paper's j − 1.
    pub fn index(self) -> usize {
        2 * self.object + usize::from(self.leg == Leg::Place)
    }

    /// This stage, or `last` where a task ends before it.
    #[must_use]
    pub fn at_most(self, last: Self) -> Self {
        if self.index() < last.index() { self } else { last }
    }

    /// The object this stage is about, counted from 0.
    pub fn object(self) -> usize {
        self.object
    }

    /// Whether the object is to be reached or placed.
    pub fn leg(self) -> Leg {
        self.leg
    }

    /// The stage a scene is in (eq. 6).
    ///
    /// It is about the first object that is not at its target, or the last one when all are; that
    /// object is reached once the gripper is within `reach_distance` (meters, the paper's d).
    /// An object that is disturbed after it was placed throws the relay back to it.
    pub fn of(
        achieved: &Achieved<N>,
        desired: &Desired<N>,
        tolerances: &Tolerances<N>,
        reach_distance: f32,
    ) -> Self {
        let scene = &achieved.0;
        let placed = |i: &usize| tolerances.placed(*i, achieved, desired);
        let object = (0..N - 1).find(|i| !placed(i)).unwrap_or(N - 1);
        let reached = is_within(&scene.gripper, &scene.objects[object], reach_distance);
        Self { object, leg: if reached { Leg::Place } else { Leg::Reach } }
    }
}
