//! What can be seen in a world, for whoever draws or records it.

use nalgebra::{Isometry3, Vector3};
use rher_core::goal::Position;

/// Red, green, blue and opacity, each in [0, 1]; as a screen has them (sRGB), not premultiplied.
pub type Color = [f32; 4];

/// A rigid thing: its shapes keep their places in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// Unlike that of every other thing in the world, such as `block_1`.
    pub name: String,
    /// What it is there for.
    pub role: Role,
    /// Where it is in the world, in meters.
    pub pose: Isometry3<f32>,
    /// What it consists of, the same in every step of an episode.
    pub shapes: Vec<Shape>,
}

/// What a [`Thing`] is there for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Nothing moves it.
    Fixed,
    /// It moves or can be moved.
    Moving,
    /// It is a mark in the air, and nothing can touch it.
    Mark,
}

/// One convex part of a [`Thing`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// What it is.
    pub form: Form,
    /// Where it is in its thing, in meters.
    pub pose: Isometry3<f32>,
    /// How it is painted.
    pub color: Color,
}

/// A form around the origin; lengths in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// From half its edges.
    Box(Vector3<f32>),
    /// Along z.
    Cylinder {
        /// From its axis to its side.
        radius: f32,
        /// From end to end.
        height: f32,
    },
    /// From its radius.
    Sphere(f32),
}

/// Largest radius of the mark of a goal, in meters.
const GOAL_RADIUS: f32 = 0.02;

/// How far a goal can be seen through.
const GOAL_OPACITY: f32 = 0.7;

impl Thing {
    /// A sphere that marks a place.
    pub fn mark(name: impl Into<String>, place: Position, radius: f32, color: Color) -> Self {
        Self {
            name: name.into(),
            role: Role::Mark,
            pose: Isometry3::from(place.coords),
            shapes: vec![Shape { form: Form::Sphere(radius), pose: Isometry3::identity(), color }],
        }
    }

    /// Marks where the object with this index should go: in its own color, and no larger than
    /// what counts as there.
    pub(crate) fn goal(index: usize, place: Position, tolerance: f32) -> Self {
        let [r, g, b, _] = object_color(index);
        let color = [r, g, b, GOAL_OPACITY];
        Self::mark(format!("goal_{}", index + 1), place, tolerance.min(GOAL_RADIUS), color)
    }
}

/// Color of the object with this index, and of its goal.
pub fn object_color(index: usize) -> Color {
    const COLORS: [Color; 3] = [[0.85, 0.25, 0.2, 1.0], [0.2, 0.6, 0.3, 1.0], [0.2, 0.4, 0.8, 1.0]];
    COLORS[index % COLORS.len()]
}
