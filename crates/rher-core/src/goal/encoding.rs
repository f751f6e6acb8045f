//! The slot rule: which goal each sub-task sees.

use super::tail::{Tail, Tails};
use super::{Achieved, Desired, Leg, Position, Stage};
use std::array;

/// One entry of an encoded goal: a position, or a blank that tells sub-tasks apart.
pub type Slot = Option<Position>;

/// The goal of one sub-task (eq. 8): the gripper's slot, then one for each object.
///
/// | sub-task  | gripper  | objects before | this object | objects after |
/// |-----------|----------|----------------|-------------|---------------|
/// | reach *i* | object i | their targets  | blank       | stay          |
/// | place *i* | blank    | their targets  | its target  | stay          |
///
/// In hindsight (eq. 9) the targets, and the gripper's goal, are what was reached later.
/// What is asked for of an object beside its position is a tail of its slot: it comes from where the
/// position comes from, and is blank with it.
/// The fields are private: this is the only place where the rule is applied.
///
/// ```
/// use rher_core::{Achieved, Desired, EncodedGoal, Position, Scene, Stage, Tolerances};
///
/// let (block, target) = (Position::new(0.3, 0.0, 0.0), Position::new(0.4, 0.0, 0.0));
/// let now = Achieved(Scene::new(Position::origin(), [block]));
/// let goal = EncodedGoal::new(Stage::place(0), &now, &Desired::of_task([target]));
/// assert_eq!((goal.gripper(), goal.objects()), (None, &[Some(target)]));
/// assert_eq!(goal.reward(&now, &Tolerances::uniform(0.05)), -1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodedGoal<const N: usize> {
    gripper: Slot,
    objects: [Slot; N],
    /// Those of blank slots mean nothing.
    tails: Tails<N>,
    last: usize,
}

impl<const N: usize> EncodedGoal<N> {
    /// Slots of the encoding.
    pub const SLOTS: usize = N + 1;

    /// Encodes `desired` for the sub-task that ends with `stage`, at a step where the scene is
    /// `now`.
    pub fn new(stage: Stage<N>, now: &Achieved<N>, desired: &Desired<N>) -> Self {
        let object = stage.object();
        let (later_objects, later_tails) = desired.later_objects(now);
        let mut objects = later_objects.map(Some);
        let tails = desired.tails().before(object + 1, &later_tails);
        for (slot, target) in objects[..object].iter_mut().zip(desired.objects()) {
            *slot = Some(*target);
        }
        match stage.leg() {
            Leg::Reach => {
                objects[object] = None;
                let gripper = Some(desired.gripper_at(object, now));
                Self { gripper, objects, tails, last: object }
            }
            Leg::Place => {
                objects[object] = Some(desired.objects()[object]);
                Self { gripper: None, objects, tails, last: object }
            }
        }
    }

    /// The gripper's slot, then the objects' in relay order.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        std::iter::once(self.gripper).chain(self.objects)
    }

    /// The gripper's slot.
    pub fn gripper(&self) -> Slot {
        self.gripper
    }

    /// The objects' slots, in relay order.
    pub fn objects(&self) -> &[Slot; N] {
        &self.objects
    }

    /// What is asked for of an object beside its position, if its slot is not blank.
    pub(crate) fn tail(&self, object: usize) -> &Tail {
        self.tails.of_object(object)
    }

    /// The last object that the sub-task is about, counted from 0.
    pub(crate) fn last(&self) -> usize {
        self.last
    }

    /// The same goal, in which objects stay where they are `now`: for goals without positions.
    #[must_use]
    pub(crate) fn staying(&self, now: &Achieved<N>) -> Self {
        let stays = |object: usize| self.objects[object].map(|_| now.0.objects[object]);
        Self { objects: array::from_fn(stays), ..*self }
    }

    /// The same goal with every position and every tail passed through these: how a scene is
    /// mirrored.
    #[must_use]
    pub(crate) fn map(
        &self,
        position: impl Fn(Position) -> Position,
        tail: impl Fn(&Tail) -> Tail,
    ) -> Self {
        Self {
            gripper: self.gripper.map(&position),
            objects: self.objects.map(|slot| slot.map(&position)),
            tails: self.tails.map(tail),
            last: self.last,
        }
    }
}
