//! How near counts as there.

#[cfg(feature = "train")]
use super::position::unit;
use super::tail::{Tail, TailSpec};
use super::{Achieved, Desired, Position, Scene};

/// How near counts as there, by slot.
///
/// ```
/// use rher_core::{Achieved, Desired, Position, Scene, Tolerances};
///
/// let near = Position::new(0.04, 0.0, 0.0);
/// let now = Achieved(Scene::new(Position::origin(), [near]));
/// let tolerances = Tolerances::uniform(0.05);
/// assert!(tolerances.placed(0, &now, &Desired::of_task([Position::origin()])));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances<const N: usize> {
    /// Of the gripper to the place it should reach, in meters.
    pub gripper: f32,
    /// Of each object to its target, in meters.
    pub objects: [f32; N],
    /// What goals say of each object beside its position, and how near counts as there in that.
    pub tail: TailSpec,
}

impl<const N: usize> Tolerances<N> {
    /// The same tolerance for every slot, in goals that are positions and nothing else.
    pub fn uniform(tolerance: f32) -> Self {
        Self { gripper: tolerance, objects: [tolerance; N], tail: TailSpec::NONE }
    }

    /// Whether an object is where it should be: within its tolerance of its target, and within those
    /// of all that is asked for beside that.
    pub fn placed(&self, object: usize, achieved: &Achieved<N>, desired: &Desired<N>) -> bool {
        let wanted = (&desired.objects()[object], desired.tails().of_object(object));
        self.is_there(object, wanted, &achieved.0)
    }

    /// Whether an object of a scene is where it is wanted.
    #[inline]
    pub(super) fn is_there(
        &self,
        object: usize,
        wanted: (&Position, &Tail),
        scene: &Scene<N>,
    ) -> bool {
        let reached = (&scene.objects[object], scene.tails.of_object(object));
        self.tail.is_there(self.objects[object], wanted, reached)
    }

    /// How far an object is from where it should be: in meters, or, where goals are more than
    /// positions, in the part in which it is furthest, in units of that part's tolerance.
    #[cfg(feature = "train")]
    pub(crate) fn distance(&self, object: usize, scene: &Scene<N>, desired: &Desired<N>) -> f32 {
        let meters = nalgebra::distance(&scene.objects[object], &desired.objects()[object]);
        if self.tail.is_none() {
            return meters;
        }
        let position = self.tail.has_positions().then(|| meters / unit(self.objects[object]));
        let [wanted, reached] = [desired.tails(), &scene.tails].map(|it| it.of_object(object));
        self.tail.in_tolerances(wanted, reached).chain(position).fold(0.0, f32::max)
    }

    /// Slot by slot in meters: the gripper's, then the objects'.
    pub fn by_slot(&self) -> impl Iterator<Item = f32> {
        std::iter::once(self.gripper).chain(self.objects)
    }

    /// The same tolerances of objects times `share`.
    pub(crate) fn scaled(&self, share: f32) -> Self {
        Self {
            gripper: self.gripper,
            objects: self.objects.map(|tolerance| share * tolerance),
            tail: self.tail.scaled(share),
        }
    }
}
