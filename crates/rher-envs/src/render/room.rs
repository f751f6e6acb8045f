//! What has to be in a picture.

use crate::simulated::Simulated;
use crate::thing::{Form, Role, Thing};
use nalgebra::{Point3, Vector3};
use rher_core::env::{EnvError, Start};
use rher_core::goal::Position;

/// An upright box in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    low: Position,
    high: Position,
}

impl Room {
    /// How far around hands and objects there has to be room, in meters.
    const AROUND: Vector3<f32> = Vector3::new(0.08, 0.08, 0.03);

    /// How far above them, for the fingers and what holds them, in meters.
    const ABOVE: f32 = 0.12;

    /// Where episodes of a task take place: the hand, the objects and their goals as each of a few
    /// dozen episodes begins, and what stands around them. Of an environment that cannot return to
    /// where it was it is where the episode takes place that begins with `start`.
    ///
    /// The environment is left as it was.
    ///
    /// # Errors
    ///
    /// If an episode cannot begin.
    pub fn of_task<const N: usize>(
        env: &mut impl Simulated<N>,
        start: &Start<N>,
    ) -> Result<Self, EnvError> {
        const EPISODES: u64 = 48;
        let mut room = Self::of_start(start);
        if let Some(snapshot) = env.snapshot() {
            let mut observation = vec![0.0; env.spec().obs_dim];
            for seed in 0..EPISODES {
                room = room.with(Self::of_start(&env.reset(seed, &mut observation)?));
            }
            env.return_to(&snapshot).map_err(EnvError::new)?;
        }
        Ok(room.roomy().with(Self::of_scenery(&env.things())))
    }

    /// Where one episode takes place, from how it begins.
    pub fn of_episode<const N: usize>(start: &Start<N>) -> Self {
        Self::of_start(start).roomy()
    }

    const NOWHERE: Self = Self {
        low: Position::new(f32::INFINITY, f32::INFINITY, f32::INFINITY),
        high: Position::new(f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY),
    };

    fn of_start<const N: usize>(start: &Start<N>) -> Self {
        let now = &start.achieved.0;
        let places = now.objects.iter().chain(start.desired.objects()).chain([&now.gripper]);
        places.fold(Self::NOWHERE, |room, place| room.with(Self { low: *place, high: *place }))
    }

    /// What nothing moves, but for tables: they may be cut off.
    fn of_scenery(things: &[Thing]) -> Self {
        let scenery =
            things.iter().filter(|thing| thing.role == Role::Fixed && thing.name != "table");
        scenery.map(Self::around).fold(Self::NOWHERE, Self::with)
    }

    /// The smallest room around a thing.
    pub(super) fn around(thing: &Thing) -> Self {
        let rooms = thing.shapes.iter().map(|shape| {
            let pose = thing.pose * shape.pose;
            let turned =
                |half: Vector3<f32>| pose.rotation.to_rotation_matrix().matrix().abs() * half;
            let half = match shape.form {
                Form::Box(half) => turned(half),
                Form::Cylinder { radius, height } => {
                    turned(Vector3::new(radius, radius, height / 2.0))
                }
                Form::Sphere(radius) => Vector3::repeat(radius),
            };
            let middle = Point3::from(pose.translation.vector);
            Self { low: middle - half, high: middle + half }
        });
        rooms.fold(Self::NOWHERE, Self::with)
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn roomy(self) -> Self {
        let above = Vector3::z() * Self::ABOVE;
        Self { low: self.low - Self::AROUND, high: self.high + Self::AROUND + above }
    }

    pub(super) fn middle(&self) -> Position {
        nalgebra::center(&self.low, &self.high)
    }

    pub(super) fn top(&self) -> f32 {
        self.high.z
    }

    pub(super) fn bottom(&self) -> f32 {
        self.low.z
    }

    pub(super) fn corners(&self) -> [Position; 8] {
        let ends = [self.low, self.high];
        std::array::from_fn(|i| Position::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z))
    }
}
