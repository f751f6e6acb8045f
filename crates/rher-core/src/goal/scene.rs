//! Positions of the gripper and the objects, as reached and as asked for.

use crate::choice::choices;
use nalgebra::Point3;
use std::iter;

/// A point in the world frame, in meters.
///
/// ```
/// use rher_core::Position;
///
/// let above = Position::new(1.3, 0.7, 0.4) + rher_core::nalgebra::Vector3::z() * 0.1;
/// assert_eq!(above.z, 0.5);
/// ```
pub type Position = Point3<f32>;

/// Where the gripper and each of `N` objects are; objects are in relay order.
///
/// ```
/// use rher_core::{Position, Scene};
///
/// let block = Position::new(0.3, 0.0, 0.0);
/// let scene = Scene { gripper: Position::origin(), objects: [block] };
/// assert_eq!(scene.places().collect::<Vec<_>>(), [Position::origin(), block]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene<const N: usize> {
    /// Grip center.
    pub gripper: Position,
    /// One center for each object.
    pub objects: [Position; N],
}

impl<const N: usize> Scene<N> {
    /// The same scene with its objects in another order; `order` says which object comes where.
    #[must_use]
    pub fn reordered(&self, order: &[usize; N]) -> Self {
        Self { gripper: self.gripper, objects: order.map(|object| self.objects[object]) }
    }

    /// The gripper's position and those of the objects.
    pub fn places(&self) -> impl Iterator<Item = Position> {
        iter::once(self.gripper).chain(self.objects)
    }

    /// Whether an object is more than a centimeter from where it was at `start`: the authors' test of
    /// whether it was touched.
    pub fn has_moved(&self, object: usize, start: &Self) -> bool {
        const MOVED: f32 = 0.01;
        nalgebra::distance(&start.objects[object], &self.objects[object]) > MOVED
    }

    /// Whether every coordinate is a finite number.
    pub fn is_finite(&self) -> bool {
        self.places().all(|place| place.coords.iter().all(|x| x.is_finite()))
    }
}

/// A scene that was reached: the paper's `s_ag`.
///
/// ```
/// use rher_core::{Achieved, Position, Scene};
///
/// let measured = Achieved(Scene { gripper: Position::origin(), objects: [Position::origin(); 2] });
/// assert!(measured.0.is_finite());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Achieved<const N: usize>(pub Scene<N>);

choices! {
    /// Hindsight goal of the objects that a sub-task does not touch.
    pub enum LaterObjects {
        /// Their positions at the step that is replayed, as in the authors' code: this goal is
        /// already met.
        Now = "now",
        /// Their positions at the later step, as in eq. 9.
        Later = "later",
    }
}

/// A scene that is asked for: the paper's `s_dg`.
///
/// It comes either from the task, or from [`Desired::in_hindsight`], and from nowhere else.
///
/// ```
/// use rher_core::{Desired, Position};
///
/// let target = Position::new(0.4, 0.1, 0.0);
/// assert_eq!(Desired::of_task([target]).objects(), &[target]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Desired<const N: usize> {
    objects: [Position; N],
    gripper: Option<Position>,
    later_objects: Option<[Position; N]>,
}

impl<const N: usize> Desired<N> {
    /// What the task asks for: a target for every object.
    ///
    /// The gripper's goal is then wherever the object to be reached is.
    pub fn of_task(objects: [Position; N]) -> Self {
        Self { objects, gripper: None, later_objects: None }
    }

    /// Hindsight (eq. 4 and 9): asks for what was in fact reached at a later step.
    pub fn in_hindsight(reached: Achieved<N>, later_objects: LaterObjects) -> Self {
        let Achieved(Scene { gripper, objects }) = reached;
        Self {
            objects,
            gripper: Some(gripper),
            later_objects: (later_objects == LaterObjects::Later).then_some(objects),
        }
    }

    /// The same wishes with the objects in another order; `order` says which object comes where.
    #[must_use]
    pub fn reordered(&self, order: &[usize; N]) -> Self {
        let reorder = |places: [Position; N]| order.map(|object| places[object]);
        Self {
            objects: reorder(self.objects),
            gripper: self.gripper,
            later_objects: self.later_objects.map(reorder),
        }
    }

    /// Target of each object.
    pub fn objects(&self) -> &[Position; N] {
        &self.objects
    }

    /// Where the gripper should be in order to reach `object`.
    pub(super) fn gripper_at(&self, object: usize, now: &Achieved<N>) -> Position {
        self.gripper.unwrap_or(now.0.objects[object])
    }

    /// Where the objects that a sub-task leaves alone should stay.
    pub(super) fn later_objects(&self, now: &Achieved<N>) -> [Position; N] {
        self.later_objects.unwrap_or(now.0.objects)
    }
}
