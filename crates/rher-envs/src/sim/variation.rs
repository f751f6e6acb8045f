//! What differs between the episodes of one world.

use super::camera::Camera;
use super::convert::glam;
use super::world::{Watch, World};
use crate::options::{Randomize, draw};
use nalgebra::Vector3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::{Collider, Vector};

impl World {
    /// Puts a camera in front of hand and objects: whatever is told of their places and velocities
    /// is what it sees.
    pub(crate) fn watch(&mut self, noise: f32, delay: usize) {
        self.watch = Some(Watch { noise, delay });
    }

    /// What was chosen last, along x, y and z; 0 before the first step.
    pub(crate) fn chosen(&self) -> Vector3<f32> {
        let [x, y, z, _] = self.state.late.chosen[0];
        Vector3::new(x, y, z)
    }

    /// Draws what a fresh world is to be like, before anything is placed in it.
    pub(crate) fn vary(&mut self, randomize: &Randomize, rng: &mut ChaCha8Rng) {
        let state = &mut self.state;
        let Randomize { friction, mass, size, sensor_noise: _, action_delay: [soonest, latest] } =
            *randomize;
        let friction = draw(friction, rng);
        if changes(friction) {
            for (_, collider) in state.colliders.iter_mut() {
                collider.set_friction(friction * collider.friction());
            }
        }
        for loose in &mut state.loose {
            let (mass, size) = (draw(mass, rng), draw(size, rng));
            if !changes(mass) && !changes(size) {
                continue;
            }
            for collider in state.bodies[loose.body.0].colliders().to_vec() {
                let collider = &mut state.colliders[collider];
                let weight = mass * collider.mass();
                let before = collider.compute_aabb().half_extents().z;
                scale(collider, size);
                collider.set_mass(weight);
                loose.raised = collider.compute_aabb().half_extents().z - before;
            }
        }
        state.late.steps = rng.random_range(soonest..=latest) as usize;
    }

    /// Begins to look at things that were all placed.
    pub(crate) fn open_eyes(&mut self, randomize: &Randomize, mut rng: ChaCha8Rng) {
        let sensor = draw(randomize.sensor_noise, &mut rng);
        let Watch { noise, delay } = self.watch.unwrap_or(Watch { noise: 0.0, delay: 0 });
        self.state.camera = (self.watch.is_some() || sensor > 0.0).then(|| {
            let noise = (noise * noise + sensor * sensor).sqrt();
            Camera::new(noise, delay, rng, self.watched())
        });
    }

    /// Looks again.
    pub(super) fn look(&mut self) {
        if let Some(mut camera) = self.state.camera.take() {
            camera.look(self.watched());
            self.state.camera = Some(camera);
        }
    }

    /// Where the hand and every loose body are.
    fn watched(&self) -> impl Iterator<Item = Vector> {
        let state = &self.state;
        let hand = state.gripper.grip(&state.bodies).position;
        let bodies = state.loose.iter().map(|loose| state.bodies[loose.body.0].translation());
        std::iter::once(glam(hand.coords)).chain(bodies)
    }
}

/// Whether a factor does anything.
fn changes(factor: f32) -> bool {
    (factor - 1.0).abs() > 0.0
}

/// Makes a box or a cylinder larger.
fn scale(collider: &mut Collider, factor: f32) {
    let shape = collider.shape_mut();
    if let Some(cuboid) = shape.as_cuboid_mut() {
        cuboid.half_extents *= factor;
    } else if let Some(cylinder) = shape.as_cylinder_mut() {
        cylinder.half_height *= factor;
        cylinder.radius *= factor;
    }
}
