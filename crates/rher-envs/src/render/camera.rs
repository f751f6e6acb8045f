//! Where a picture is taken from.

use super::depth::Corner;
use super::faces::Surface;
use crate::thing::{Form, Role, Thing};
use nalgebra::{Matrix3, Point3, Vector3};
use rher_core::goal::Position;

/// What is nearer to the eye than this is not seen, in meters.
const NEAREST: f32 = 0.02;

/// From where, towards what, and how wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is, in meters.
    pub eye: Position,
    /// What is in the middle of the picture; not right above or below the eye.
    pub focus: Position,
    /// How much of the world the height of the picture shows, in radians.
    pub field_of_view: f32,
}

impl Camera {
    /// Over the robot's right shoulder: x goes to the right, y to the left, both away; the table
    /// fills the picture, with room for a hand above what stands on it.
    pub fn above_table(things: &[Thing]) -> Self {
        /// From the focus to the eye, if the table were as wide as its diagonal is one meter.
        const BACK: Vector3<f32> = Vector3::new(-0.80, -0.98, 0.95);
        /// How much higher than the table the middle of the picture is, in meters.
        const HIGHER: f32 = 0.09;
        let (top, diagonal) = table(things).unwrap_or((Position::new(1.3, 0.75, 0.4), 0.86));
        let tallest = tallest(things, top.z);
        let focus = top + Vector3::z() * (HIGHER + tallest / 2.0);
        Self { eye: focus + BACK * diagonal * (1.0 + tallest), focus, field_of_view: 0.44 }
    }

    /// This camera in front of a picture of this many samples.
    #[expect(
        clippy::disallowed_methods,
        reason = "what is drawn is looked at, and nothing is computed from it"
    )]
    pub(super) fn view(&self, width: usize, height: usize) -> View {
        let forward = (self.focus - self.eye).normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let down = forward.cross(&right);
        let middle = [width as f32 / 2.0, height as f32 / 2.0];
        View {
            eye: self.eye,
            to_camera: Matrix3::from_rows(&[right, down, forward].map(|axis| axis.transpose())),
            middle,
            scale: middle[1] / (self.field_of_view / 2.0).tan(),
        }
    }
}

/// The middle of the table's top and the length of its diagonal.
fn table(things: &[Thing]) -> Option<(Position, f32)> {
    let table = things.iter().find(|thing| thing.name == "table")?;
    let Form::Box(half) = table.shapes.first()?.form else { return None };
    let top = table.pose * Point3::new(0.0, 0.0, half.z);
    Some((top, 2.0 * half.xy().norm()))
}

/// How far the boxes that nothing moves rise above the height of the table's top, in meters.
fn tallest(things: &[Thing], top: f32) -> f32 {
    let fixed = things.iter().filter(|thing| thing.role == Role::Fixed);
    let shapes = fixed.flat_map(|thing| thing.shapes.iter().map(move |shape| (thing, shape)));
    let rises = shapes.filter_map(|(thing, shape)| {
        let Form::Box(half) = shape.form else { return None };
        let pose = thing.pose * shape.pose;
        let upright = pose.rotation.to_rotation_matrix().matrix().row(2).abs();
        Some(pose.translation.z + upright.tr_dot(&half) - top)
    });
    rises.fold(0.0, f32::max)
}

/// From the world to samples and back.
pub(super) struct View {
    eye: Position,
    /// Rows: to the right, down, forward.
    to_camera: Matrix3<f32>,
    /// Of the picture, in samples.
    middle: [f32; 2],
    /// Samples in a meter that is one meter away.
    scale: f32,
}

impl View {
    /// Whether the eye sees the outer side of a face.
    pub(super) fn is_in_front(&self, surface: &Surface, corners: &[Position]) -> bool {
        let middle = nalgebra::center(&corners[0], &corners[corners.len() / 2]);
        surface.normal(&middle).dot(&(self.eye - middle)) > 0.0
    }

    /// Hands the part of a convex polygon that is before the eye to `draw`, in samples.
    pub(super) fn project(&self, corners: &[Position], draw: impl FnOnce(&[Corner])) {
        const ROOM: usize = 64;
        let mut polygon = [Corner::default(); ROOM];
        let mut count = 0;
        let seen = |corner: &Position| self.to_camera * (corner - self.eye);
        let Some(last) = corners.last() else { return };
        let mut before = seen(last);
        for corner in corners.iter().take(ROOM / 2) {
            let now = seen(corner);
            if (before.z < NEAREST) != (now.z < NEAREST) {
                let share = (NEAREST - before.z) / (now.z - before.z);
                polygon[count] = self.corner(&before.lerp(&now, share));
                count += 1;
            }
            if now.z >= NEAREST {
                polygon[count] = self.corner(&now);
                count += 1;
            }
            before = now;
        }
        draw(&polygon[..count]);
    }

    fn corner(&self, seen: &Vector3<f32>) -> Corner {
        let nearness = 1.0 / seen.z;
        let [x, y] = self.middle;
        Corner {
            x: x + self.scale * seen.x * nearness,
            y: y + self.scale * seen.y * nearness,
            nearness,
        }
    }

    /// The place in the world that is seen in the middle of a sample.
    pub(super) fn place(&self, x: usize, y: usize, nearness: f32) -> Position {
        let ray = Vector3::new(
            (x as f32 + 0.5 - self.middle[0]) / self.scale,
            (y as f32 + 0.5 - self.middle[1]) / self.scale,
            1.0,
        );
        self.eye + self.to_camera.tr_mul(&ray) / nearness
    }
}
