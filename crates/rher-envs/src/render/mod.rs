//! Pictures of a world, drawn by the processor alone.
//!
//! ```
//! use rher_core::env::Env as _;
//! use rher_envs::render::{Renderer, Viewpoint, scene};
//! use rher_envs::{Simulation, tasks::Push};
//! use std::num::NonZeroU16;
//!
//! let mut env = Simulation::<Push, 1>::new();
//! let mut observation = vec![0.0; env.spec().obs_dim];
//! let start = env.reset(7, &mut observation)?;
//! let camera = Viewpoint::Corner.camera(&mut env, &start)?;
//! let size = [320, 240].map(|pixels| NonZeroU16::new(pixels).expect("not 0"));
//! let image = Renderer::new(size).draw(&camera, &scene(&mut env, &start.achieved, &start.desired));
//! assert_eq!(image.rgb.len(), 320 * 240 * 3);
//! assert!(image.png()?.starts_with(b"\x89PNG"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod camera;
mod depth;
mod faces;
mod image;
mod letters;
mod light;
mod room;
mod scene;
mod viewpoint;

pub use camera::Camera;
pub use image::{Image, PngError};
pub use room::Room;
pub use scene::scene;
pub use viewpoint::Viewpoint;

use crate::thing::{Role, Thing};
use camera::View;
use depth::{DepthBuffer, NONE};
use faces::Surface;
use image::encode;
use light::Light;
use nalgebra::Vector3;
use std::num::NonZeroU16;

/// Samples along each edge of a pixel.
const SAMPLES: usize = 2;

/// How much of a mark is still seen behind other things.
const BEHIND: f32 = 0.3;

/// How far behind other things a mark has faded so far, in meters: not at once, since a mark may lie
/// on the surface of a thing.
const FADED: f32 = 0.012;

/// Colors at the bottom and at the top of what is behind everything (linear).
const BACKGROUND: [Vector3<f32>; 2] =
    [Vector3::new(0.50, 0.53, 0.57), Vector3::new(0.80, 0.84, 0.88)];

/// Draws worlds, with shadows, into pictures of one size.
///
/// A depth buffer and not the order of painters: a finger in a drawer in a cabinet has no order.
pub struct Renderer {
    width: usize,
    height: usize,
    solid: DepthBuffer,
    marks: DepthBuffer,
    light: Light,
    surfaces: Vec<Surface>,
}

impl Renderer {
    /// Draws pictures of this width and height, in pixels.
    pub fn new(size: [NonZeroU16; 2]) -> Self {
        let [width, height] = size.map(|pixels| usize::from(pixels.get()));
        let buffer = || DepthBuffer::new(SAMPLES * width, SAMPLES * height);
        Self {
            width,
            height,
            solid: buffer(),
            marks: buffer(),
            light: Light::new(),
            surfaces: Vec::new(),
        }
    }

    /// What `camera` sees of `things`; marks shine through what is before them.
    pub fn draw(&mut self, camera: &Camera, things: &[Thing]) -> Image {
        let view = camera.view(self.solid.width(), self.solid.height());
        self.light.shine_on(things);
        self.surfaces.clear();
        self.solid.clear();
        self.marks.clear();
        for thing in things {
            let is_mark = thing.role == Role::Mark;
            let buffer = if is_mark { &mut self.marks } else { &mut self.solid };
            for shape in &thing.shapes {
                faces::of(shape, &thing.pose, |surface, corners| {
                    if self.surfaces.last() != Some(&surface) {
                        self.surfaces.push(surface);
                    }
                    let id = self.surfaces.len() as u32 - 1;
                    if view.is_in_front(&surface, corners) {
                        view.project(corners, |polygon| buffer.fill(polygon, id));
                    }
                });
            }
        }
        self.resolve(&view)
    }

    fn resolve(&self, view: &View) -> Image {
        let mut rgb = Vec::with_capacity(3 * self.width * self.height);
        for y in 0..self.height {
            let [low, high] = BACKGROUND;
            let background = high.lerp(&low, y as f32 / self.height as f32);
            for x in 0..self.width {
                let samples = samples(x, y);
                let mut color = self.mean(view, &samples, &background);
                self.put_marks_on(view, &samples, &mut color);
                rgb.extend(encode(&color));
            }
        }
        Image { width: self.width, height: self.height, rgb }
    }

    /// The color of a pixel without marks: a surface is shaded once for samples in a row.
    fn mean(&self, view: &View, samples: &[[usize; 2]], behind: &Vector3<f32>) -> Vector3<f32> {
        let mut sum = Vector3::zeros();
        let mut last = (NONE, *behind);
        for &[x, y] in samples {
            let (id, nearness) = self.solid.at(x, y);
            if id != last.0 {
                let color = if id == NONE { *behind } else { self.shade(id, view, x, y, nearness) };
                last = (id, color);
            }
            sum += last.1;
        }
        sum / samples.len() as f32
    }

    /// Paints marks over the color of a pixel: a surface is shaded once for samples in a row.
    fn put_marks_on(&self, view: &View, samples: &[[usize; 2]], color: &mut Vector3<f32>) {
        let mut paint = Vector3::zeros();
        let mut opacity = 0.0;
        let mut last = (NONE, Vector3::zeros());
        for &[x, y] in samples {
            let (id, nearness) = self.marks.at(x, y);
            if id == NONE {
                continue;
            }
            if id != last.0 {
                last = (id, self.shade(id, view, x, y, nearness));
            }
            let share = self.surfaces[id as usize].opacity * self.seen(x, y, nearness);
            paint += last.1 * share;
            opacity += share;
        }
        let count = samples.len() as f32;
        *color = *color * (1.0 - opacity / count) + paint / count;
    }

    /// How much of a mark is seen in a sample: less behind what is solid.
    fn seen(&self, x: usize, y: usize, nearness: f32) -> f32 {
        let (id, solid) = self.solid.at(x, y);
        let behind = if id == NONE { 0.0 } else { 1.0 / nearness - 1.0 / solid };
        1.0 - (1.0 - BEHIND) * (behind / FADED).clamp(0.0, 1.0)
    }

    /// The color of a surface in a sample.
    fn shade(&self, id: u32, view: &View, x: usize, y: usize, nearness: f32) -> Vector3<f32> {
        self.light.shade(&self.surfaces[id as usize], &view.place(x, y, nearness))
    }
}

/// The samples of a pixel.
fn samples(x: usize, y: usize) -> [[usize; 2]; SAMPLES * SAMPLES] {
    std::array::from_fn(|i| [SAMPLES * x + i % SAMPLES, SAMPLES * y + i / SAMPLES])
}
