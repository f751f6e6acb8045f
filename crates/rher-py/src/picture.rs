//! Pictures of environments.

use rher_core::env::{EnvError, Start};
use rher_core::goal::{Achieved, Desired, Position, Scene};
use rher_envs::Simulated;
use rher_envs::render::{Camera, Image, Renderer, Viewpoint, scene};
use std::num::NonZeroU16;

/// Draws environments of one task.
pub(crate) struct Painter {
    renderer: Renderer,
    /// Chosen when the first picture is drawn.
    camera: Option<Camera>,
}

impl Painter {
    /// Draws pictures of this width and height, in pixels.
    pub(crate) fn new(size: [NonZeroU16; 2]) -> Self {
        Self { renderer: Renderer::new(size), camera: None }
    }

    /// A picture of this moment of an episode that was started; `achieved` is the achieved goal.
    pub(crate) fn draw<const N: usize>(
        &mut self,
        env: &mut impl Simulated<N>,
        achieved: [Position; N],
        desired: &Desired<N>,
    ) -> Result<Image, EnvError> {
        let now = Achieved(Scene::new(achieved[0], achieved));
        let camera = if let Some(camera) = self.camera {
            camera
        } else {
            let start = Start { achieved: now, desired: *desired };
            *self.camera.insert(Viewpoint::default().camera(env, &start)?)
        };
        Ok(self.renderer.draw(&camera, &scene(env, &now, desired)))
    }
}
