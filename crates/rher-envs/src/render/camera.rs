//! Where a picture is taken from.

use super::depth::Corner;
use super::faces::Surface;
use super::room::Room;
use nalgebra::{Matrix3, Vector2, Vector3};
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
    /// How much of the world the height of a picture of 4 by 3 shows, in radians; a wider picture
    /// shows more at its sides, a narrower one more above and below.
    pub field_of_view: f32,
}

impl Camera {
    /// A camera in this direction from the middle of a room, as near as it can be with the whole
    /// room in a picture of 4 by 3. The direction is not vertical; the field of view is in radians.
    pub fn facing(from_room: Vector3<f32>, field_of_view: f32, room: &Room) -> Self {
        /// Each brings the room a little nearer to the middle of the picture.
        const ROUNDS: usize = 4;
        let axes = axes(&-from_room);
        let half = half_size(field_of_view);
        let mut focus = room.middle();
        let mut distance: f32 = 0.0;
        for _ in 0..ROUNDS {
            let corners = room.corners().map(|corner| axes * (corner - focus));
            let distances =
                corners.map(|seen| (seen.x.abs() / half.x).max(seen.y.abs() / half.y) - seen.z);
            distance = distances.into_iter().fold(NEAREST, f32::max);
            let places = corners.map(|seen| seen.xy() / (distance + seen.z));
            let least = places.iter().fold(places[0], |least, place| least.inf(place));
            let most = places.iter().fold(places[0], |most, place| most.sup(place));
            let middle = (least + most) * (distance / 2.0);
            focus += axes.tr_mul(&Vector3::new(middle.x, middle.y, 0.0));
        }
        // What was moved last may stand out by a hair.
        Self { eye: focus + from_room.normalize() * distance, focus, field_of_view }
    }

    /// This camera in front of a picture of this many samples.
    pub(super) fn view(&self, width: usize, height: usize) -> View {
        let middle = [width as f32 / 2.0, height as f32 / 2.0];
        View {
            eye: self.eye,
            to_camera: axes(&(self.focus - self.eye)),
            middle,
            scale: middle[1].min(middle[0] / ASPECT) / half_size(self.field_of_view).y,
        }
    }
}

/// Width over height of a picture that shows the field of view and no more.
const ASPECT: f32 = 4.0 / 3.0;

/// Rows: to the right, down, forward.
fn axes(forward: &Vector3<f32>) -> Matrix3<f32> {
    let forward = forward.normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let down = forward.cross(&right);
    Matrix3::from_rows(&[right, down, forward].map(|axis| axis.transpose()))
}

/// Half the width and half the height of what a picture of 4 by 3 shows at a distance of 1 meter, in
/// meters.
#[expect(
    clippy::disallowed_methods,
    reason = "what is drawn is looked at, and nothing is computed from it"
)]
fn half_size(field_of_view: f32) -> Vector2<f32> {
    let half = (field_of_view / 2.0).tan();
    Vector2::new(ASPECT * half, half)
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
