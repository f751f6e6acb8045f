//! The cameras by name.

use super::camera::Camera;
use super::room::Room;
use crate::simulated::Simulated;
use nalgebra::Vector3;
use rher_core::env::{EnvError, Start};

/// From where a task is looked at, so that its hand, objects and goals are in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Viewpoint {
    /// Over the robot's right shoulder: x goes to the right, y to the left, both away.
    #[default]
    Corner,
    /// Opposite the robot, from above: x comes nearer, y goes to the right.
    Front,
    /// From the robot's right, nearly level: x goes to the right, z up.
    Side,
    /// From above, as on a map: x goes to the right, y up.
    Top,
    /// As [`Corner`](Self::Corner), but as near as the beginning of the episode allows.
    Close,
}

impl Viewpoint {
    /// Every viewpoint.
    pub const ALL: [Self; 5] = [Self::Corner, Self::Front, Self::Side, Self::Top, Self::Close];

    /// What it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Corner => "corner",
            Self::Front => "front",
            Self::Side => "side",
            Self::Top => "top",
            Self::Close => "close",
        }
    }

    /// The viewpoint that is called so.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|viewpoint| viewpoint.name() == name)
    }

    /// The camera for an episode of `env` that begins with `start`: the same for every episode, but
    /// for [`Close`](Self::Close). The environment is left as it was.
    ///
    /// # Errors
    ///
    /// If the environment fails.
    pub fn camera<const N: usize>(
        self,
        env: &mut impl Simulated<N>,
        start: &Start<N>,
    ) -> Result<Camera, EnvError> {
        let room = match self {
            Self::Close => Room::of_episode(start),
            Self::Corner | Self::Front | Self::Side | Self::Top => Room::of_task(env, start)?,
        };
        Ok(Camera::facing(self.direction(), self.field_of_view(), &room))
    }

    /// From what is looked at to the eye.
    fn direction(self) -> Vector3<f32> {
        match self {
            Self::Corner | Self::Close => Vector3::new(-0.74, -0.92, 1.05),
            Self::Front => Vector3::new(0.75, -0.12, 0.95),
            Self::Side => Vector3::new(-0.05, -1.0, 0.28),
            Self::Top => Vector3::new(0.0, -0.02, 1.0),
        }
    }

    /// In radians.
    fn field_of_view(self) -> f32 {
        match self {
            Self::Corner | Self::Front | Self::Side | Self::Close => 0.44,
            // From far away, so that an arm does not hide what is around its hand.
            Self::Top => 0.12,
        }
    }
}
