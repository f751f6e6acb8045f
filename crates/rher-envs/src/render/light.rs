//! Light from one direction, shadows, and light from everywhere.

use super::depth::{Corner, DepthBuffer, NONE};
use super::faces::{self, Surface};
use super::scene::ARM;
use crate::thing::{Role, Thing};
use nalgebra::{Matrix3, Vector3};
use rher_core::goal::Position;

/// Samples along each edge of the map of what is in the light.
const MAP: usize = 448;

/// From the world towards the light: nearly from above, so that a shadow shows where a thing is.
const TOWARDS: Vector3<f32> = Vector3::new(-0.14, 0.12, 1.0);

/// From the world towards where the sky is brightest.
const SKY: Vector3<f32> = Vector3::new(-0.42, 0.22, 0.88);

/// How bright the light is.
const DIRECT: f32 = 0.52;

/// Brightness of what comes from all around, on the dark side and on that of the sky.
const AROUND: [f32; 2] = [0.16, 0.54];

/// How much nearer to the light something has to be to throw a shadow, in meters.
const BIAS: f32 = 0.003;

pub(super) struct Light {
    /// Rows: across the map, down the map, towards the light.
    axes: Matrix3<f32>,
    /// In meters.
    middle: Vector3<f32>,
    /// Samples in a meter.
    scale: f32,
    map: DepthBuffer,
}

impl Light {
    pub(super) fn new() -> Self {
        let towards = TOWARDS.normalize();
        let across = Vector3::y().cross(&towards).normalize();
        let down = towards.cross(&across);
        Self {
            axes: Matrix3::from_rows(&[across, down, towards].map(|axis| axis.transpose())),
            middle: Vector3::zeros(),
            scale: 1.0,
            map: DepthBuffer::new(MAP, MAP),
        }
    }

    /// Finds out what is in the light.
    ///
    /// Tables throw no shadow that anyone sees, marks none at all, and that of an arm would hide
    /// where the hand is.
    pub(super) fn shine_on(&mut self, things: &[Thing]) {
        self.map.clear();
        let casts =
            |thing: &&Thing| thing.role != Role::Mark && thing.name != "table" && thing.name != ARM;
        let casters = || things.iter().filter(casts);
        let mut box_of_all = [Vector3::repeat(f32::INFINITY), Vector3::repeat(f32::NEG_INFINITY)];
        for thing in casters() {
            each_face(thing, |_, corners| {
                for corner in corners {
                    let corner = self.axes * corner.coords;
                    box_of_all = [box_of_all[0].inf(&corner), box_of_all[1].sup(&corner)];
                }
            });
        }
        let [low, high] = box_of_all;
        let size = (high - low).xy().max();
        if !size.is_finite() || size <= 0.0 {
            return;
        }
        self.middle = nalgebra::center(&low.into(), &high.into()).coords;
        self.scale = (MAP - 4) as f32 / size;
        let Self { axes, middle, scale, map } = self;
        let towards = axes.row(2).transpose();
        for thing in casters() {
            each_face(thing, |surface, corners| {
                let center = nalgebra::center(&corners[0], &corners[corners.len() / 2]);
                if surface.normal(&center).dot(&towards) <= 0.0 {
                    return;
                }
                let mut polygon = [Corner::default(); 32];
                for (out, corner) in polygon.iter_mut().zip(corners) {
                    *out = in_map(axes, middle, *scale, corner);
                }
                map.fill(&polygon[..corners.len().min(polygon.len())], 0);
            });
        }
    }

    /// The linear color of a surface at a place on it.
    pub(super) fn shade(&self, surface: &Surface, place: &Position) -> Vector3<f32> {
        let normal = surface.normal(place);
        let [dark, bright] = AROUND;
        let around = dark + (bright - dark) * f32::midpoint(normal.dot(&SKY), 1.0);
        let towards = self.axes.row(2).transpose();
        let direct = DIRECT * normal.dot(&towards).max(0.0);
        let lit = if direct > 0.0 { self.lit(&(place + normal * BIAS)) } else { 0.0 };
        surface.color * (around + direct * lit)
    }

    /// How much of the light comes to a place: 0 in shadow, 1 in the light.
    fn lit(&self, place: &Position) -> f32 {
        let Corner { x, y, nearness } = in_map(&self.axes, &self.middle, self.scale, place);
        let (x, y) = (x - 0.5, y - 0.5);
        let inside = 0.0..(MAP - 1) as f32;
        if !inside.contains(&x) || !inside.contains(&y) {
            return 1.0;
        }
        let (right_share, down_share) = (x - (x as usize) as f32, y - (y as usize) as f32);
        let lit = |x: usize, y: usize| {
            let (id, nearest) = self.map.at(x, y);
            f32::from(id == NONE || nearest <= nearness + BIAS)
        };
        let (x, y) = (x as usize, y as usize);
        let row = |y: usize| lit(x, y) + (lit(x + 1, y) - lit(x, y)) * right_share;
        row(y) + (row(y + 1) - row(y)) * down_share
    }
}

fn each_face(thing: &Thing, mut visit: impl FnMut(Surface, &[Position])) {
    for shape in &thing.shapes {
        faces::of(shape, &thing.pose, &mut visit);
    }
}

fn in_map(axes: &Matrix3<f32>, middle: &Vector3<f32>, scale: f32, place: &Position) -> Corner {
    let place = axes * place.coords - middle;
    let half = MAP as f32 / 2.0;
    Corner { x: half + scale * place.x, y: half + scale * place.y, nearness: place.z }
}
