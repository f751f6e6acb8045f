//! Where the gripper and the objects are, and what else goals say of them, as reached and as asked
//! for.

use super::position::Position;
use super::tail::{Tail, Tails};
use crate::choice::choices;
use std::{array, iter};

/// Where the gripper and each of `N` objects are; objects are in relay order.
///
/// ```
/// use rher_core::{Position, Scene};
///
/// let block = Position::new(0.3, 0.0, 0.0);
/// let scene = Scene::new(Position::origin(), [block]);
/// assert_eq!(scene.places().collect::<Vec<_>>(), [Position::origin(), block]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene<const N: usize> {
    /// Grip center.
    pub gripper: Position,
    /// One center for each object.
    pub objects: [Position; N],
    /// What else goals may say of each object.
    pub tails: Tails<N>,
}

impl<const N: usize> Scene<N> {
    /// A scene in which nothing but positions matters.
    pub fn new(gripper: Position, objects: [Position; N]) -> Self {
        Self { gripper, objects, tails: Tails::default() }
    }

    /// The same scene, with what else goals may say of each object.
    #[must_use]
    pub fn with_tails(self, tails: Tails<N>) -> Self {
        Self { tails, ..self }
    }

    /// The same scene with its objects in another order; `order` says which object comes where.
    #[must_use]
    pub fn reordered(&self, order: &[usize; N]) -> Self {
        Self {
            gripper: self.gripper,
            objects: order.map(|object| self.objects[object]),
            tails: self.tails.reordered(order),
        }
    }

    /// How many numbers a scene has, of whose objects goals say `tail` numbers beside the position.
    pub const fn width(tail: usize) -> usize {
        3 + N * (3 + tail)
    }

    /// The scene of these numbers, in the order of [`Scene::numbers`].
    ///
    /// # Panics
    ///
    /// If there are fewer than [`Scene::width`].
    #[inline]
    pub fn read(numbers: &[f32], tail: usize) -> Self {
        let (gripper, objects) = numbers.split_at(3);
        let (objects, tails) = read_objects(objects, tail);
        Self { gripper: place(gripper, 0), objects, tails }
    }

    /// Its numbers: the gripper's position, those of the objects, and the first `tail` numbers of
    /// every object's tail.
    pub fn numbers(&self, tail: usize) -> impl Iterator<Item = f32> {
        self.places().flat_map(|place| [place.x, place.y, place.z]).chain(self.tails.numbers(tail))
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

    /// Whether every coordinate, and every number beside them, is finite.
    pub fn is_finite(&self) -> bool {
        self.places().all(|place| place.coords.iter().all(|x| x.is_finite()))
            && self.tails.all().iter().all(|number| number.is_finite())
    }

    /// The same scene with every position and every tail passed through these.
    #[must_use]
    pub(crate) fn map(
        &self,
        position: impl Fn(Position) -> Position,
        tail: impl Fn(&Tail) -> Tail,
    ) -> Self {
        Self {
            gripper: position(self.gripper),
            objects: self.objects.map(position),
            tails: self.tails.map(tail),
        }
    }
}

/// One of the positions that stand one after the other.
#[inline]
fn place(numbers: &[f32], index: usize) -> Position {
    Position::new(numbers[3 * index], numbers[3 * index + 1], numbers[3 * index + 2])
}

/// The positions of objects, and their tails, which follow.
#[inline]
fn read_objects<const N: usize>(numbers: &[f32], tail: usize) -> ([Position; N], Tails<N>) {
    let (places, tails) = numbers.split_at(3 * N);
    (array::from_fn(|object| place(places, object)), Tails::read(tails, tail))
}

/// A scene that was reached: the paper's `s_ag`.
///
/// ```
/// use rher_core::{Achieved, Position, Scene};
///
/// let measured = Achieved(Scene::new(Position::origin(), [Position::origin(); 2]));
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
    tails: Tails<N>,
    gripper: Option<Position>,
    /// Whether an object that a sub-task leaves alone should be where it is asked for; otherwise it
    /// should stay where it is.
    later_objects_move: bool,
}

impl<const N: usize> Desired<N> {
    /// What the task asks for: a target for every object.
    ///
    /// The gripper's goal is then wherever the object to be reached is.
    pub fn of_task(objects: [Position; N]) -> Self {
        Self { objects, tails: Tails::default(), gripper: None, later_objects_move: false }
    }

    /// The same wishes, with what else is asked for of each object.
    #[must_use]
    pub fn with_tails(self, tails: Tails<N>) -> Self {
        Self { tails, ..self }
    }

    /// How many numbers the wishes of a task have.
    pub const fn width(tail: usize) -> usize {
        N * (3 + tail)
    }

    /// What the task asks for, from the numbers that [`Desired::numbers`] gives.
    ///
    /// # Panics
    ///
    /// If there are fewer than [`Desired::width`].
    pub fn read(numbers: &[f32], tail: usize) -> Self {
        let (objects, tails) = read_objects(numbers, tail);
        Self::of_task(objects).with_tails(tails)
    }

    /// The numbers of the wishes of a task: the target of each object, and the first `tail` numbers
    /// of every object's tail.
    pub fn numbers(&self, tail: usize) -> impl Iterator<Item = f32> {
        let places = self.objects.iter().flat_map(|place| [place.x, place.y, place.z]);
        places.chain(self.tails.numbers(tail))
    }

    /// Hindsight (eq. 4 and 9): asks for what was in fact reached at a later step.
    pub fn in_hindsight(reached: Achieved<N>, later_objects: LaterObjects) -> Self {
        let Achieved(Scene { gripper, objects, tails }) = reached;
        let later_objects_move = later_objects == LaterObjects::Later;
        Self { objects, tails, gripper: Some(gripper), later_objects_move }
    }

    /// The same wishes with the objects in another order; `order` says which object comes where.
    #[must_use]
    pub fn reordered(&self, order: &[usize; N]) -> Self {
        Self {
            objects: order.map(|object| self.objects[object]),
            tails: self.tails.reordered(order),
            ..*self
        }
    }

    /// Target of each object.
    pub fn objects(&self) -> &[Position; N] {
        &self.objects
    }

    /// What else is asked for of each object.
    pub fn tails(&self) -> &Tails<N> {
        &self.tails
    }

    /// Where the gripper should be in order to reach `object`.
    pub(super) fn gripper_at(&self, object: usize, now: &Achieved<N>) -> Position {
        self.gripper.unwrap_or(now.0.objects[object])
    }

    /// Where the objects that a sub-task leaves alone should be, and what else is asked of them.
    pub(super) fn later_objects(&self, now: &Achieved<N>) -> ([Position; N], Tails<N>) {
        if self.later_objects_move {
            (self.objects, self.tails)
        } else {
            (now.0.objects, now.0.tails)
        }
    }
}
