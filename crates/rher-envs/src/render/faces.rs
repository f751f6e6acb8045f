//! The outsides of shapes, as convex polygons.

use super::image::linear;
use crate::thing::{Form, Shape};
use nalgebra::{Isometry3, Point3, Vector3};
use rher_core::goal::Position;
use std::array;
use std::f32::consts::{PI, TAU};

/// Sides of what is round.
const SIDES: usize = 24;

/// What of a shape is shaded as one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Surface {
    curve: Curve,
    /// Linear red, green and blue.
    pub(super) color: Vector3<f32>,
    /// 1 hides all behind it.
    pub(super) opacity: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Curve {
    /// The direction it faces.
    Flat(Vector3<f32>),
    /// A point of the axis, and its direction.
    Cylinder(Position, Vector3<f32>),
    /// The center.
    Sphere(Position),
}

impl Surface {
    /// The direction it faces at a place on it, of length 1.
    pub(super) fn normal(&self, place: &Position) -> Vector3<f32> {
        match self.curve {
            Curve::Flat(normal) => normal,
            Curve::Cylinder(middle, axis) => {
                let out = place - middle;
                (out - axis * axis.dot(&out)).normalize()
            }
            Curve::Sphere(middle) => (place - middle).normalize(),
        }
    }
}

/// Hands every face of a shape to `draw`, with its surface; faces of one surface in a row.
#[expect(
    clippy::disallowed_methods,
    reason = "what is drawn is looked at, and nothing is computed from it"
)]
pub(super) fn of(
    shape: &Shape,
    thing: &Isometry3<f32>,
    mut draw: impl FnMut(Surface, &[Position]),
) {
    let pose = thing * shape.pose;
    let [r, g, b, opacity] = shape.color;
    let color = Vector3::new(linear(r), linear(g), linear(b));
    let surface = |curve| Surface { curve, color, opacity };
    match shape.form {
        Form::Box(half) => {
            for axis in 0..3 {
                for sign in [1.0, -1.0] {
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
                    let corners = corners.map(|(along_u, along_v)| {
                        let mut corner = half;
                        corner[axis] *= sign;
                        corner[u] *= along_u;
                        corner[v] *= along_v;
                        pose * Point3::from(corner)
                    });
                    let mut out = Vector3::zeros();
                    out[axis] = sign;
                    draw(surface(Curve::Flat(pose * out)), &corners);
                }
            }
        }
        Form::Cylinder { radius, height } => {
            let ring = |z: f32| -> [Position; SIDES] {
                array::from_fn(|side| {
                    let (sine, cosine) = (TAU * side as f32 / SIDES as f32).sin_cos();
                    pose * Point3::new(radius * cosine, radius * sine, z)
                })
            };
            let [low, high] = [ring(-height / 2.0), ring(height / 2.0)];
            let axis = pose * Vector3::z();
            draw(surface(Curve::Flat(axis)), &high);
            draw(surface(Curve::Flat(-axis)), &low);
            let round = surface(Curve::Cylinder(pose * Point3::origin(), axis));
            for side in 0..SIDES {
                let next = (side + 1) % SIDES;
                draw(round, &[low[side], low[next], high[next], high[side]]);
            }
        }
        Form::Sphere(radius) => {
            let round = surface(Curve::Sphere(pose * Point3::origin()));
            let at = |row: usize, side: usize| {
                let (sine, cosine) = (PI * row as f32 / (SIDES / 2) as f32).sin_cos();
                let (y, x) = (TAU * side as f32 / SIDES as f32).sin_cos();
                pose * Point3::from(Vector3::new(sine * x, sine * y, cosine) * radius)
            };
            for row in 0..SIDES / 2 {
                for side in 0..SIDES {
                    let corners =
                        [(row, side), (row + 1, side), (row + 1, side + 1), (row, side + 1)];
                    draw(round, &corners.map(|(row, side)| at(row, side)));
                }
            }
        }
    }
}
