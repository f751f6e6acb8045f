//! The slot rule: which goal each sub-task sees.

use super::{Achieved, Desired, Leg, Position, Stage};

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
/// The fields are private: this is the only place where the rule is applied.
///
/// ```
/// use rher_core::{Achieved, Desired, EncodedGoal, Position, Scene, Stage, Tolerances};
///
/// let (block, target) = (Position::new(0.3, 0.0, 0.0), Position::new(0.4, 0.0, 0.0));
/// let now = Achieved(Scene { gripper: Position::origin(), objects: [block] });
/// let goal = EncodedGoal::new(Stage::place(0), &now, &Desired::of_task([target]));
/// assert_eq!((goal.gripper(), goal.objects()), (None, &[Some(target)]));
/// assert_eq!(goal.reward(&now, &Tolerances::uniform(0.05)), -1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodedGoal<const N: usize> {
    gripper: Slot,
    objects: [Slot; N],
    last: usize,
}

impl<const N: usize> EncodedGoal<N> {
    /// Slots of the encoding.
    pub const SLOTS: usize = N + 1;

    /// Encodes `desired` for the sub-task that ends with `stage`, at a step where the scene is
    /// `now`.
    pub fn new(stage: Stage<N>, now: &Achieved<N>, desired: &Desired<N>) -> Self {
        let object = stage.object();
        let mut objects = desired.later_objects(now).map(Some);
        for (slot, target) in objects[..object].iter_mut().zip(desired.objects()) {
            *slot = Some(*target);
        }
        match stage.leg() {
            Leg::Reach => {
                objects[object] = None;
                Self { gripper: Some(desired.gripper_at(object, now)), objects, last: object }
            }
            Leg::Place => {
                objects[object] = Some(desired.objects()[object]);
                Self { gripper: None, objects, last: object }
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

    /// The last object that the sub-task is about, counted from 0.
    pub(crate) fn last(&self) -> usize {
        self.last
    }

    /// The same goal with every position passed through `map`: how a scene is mirrored.
    #[must_use]
    pub fn map(&self, map: impl Fn(Position) -> Position) -> Self {
        Self {
            gripper: self.gripper.map(&map),
            objects: self.objects.map(|slot| slot.map(&map)),
            last: self.last,
        }
    }
}
