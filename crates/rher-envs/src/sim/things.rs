//! What is visible in a world.

use super::convert::nalgebra;
use super::look::{Look, Solid};
use super::world::World;
use crate::thing::{Color, Form, Role, Shape, Thing};
use ::nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::{Collider, Pose};
use std::f32::consts::FRAC_PI_2;

const HAND: Color = [0.25, 0.27, 0.31, 1.0];

/// Half the edges of the palm above the fingers, in meters; it is seen and not felt.
const PALM_HALF: Vector3<f32> = Vector3::new(0.02, 0.068, 0.014);

/// Radius and height of the wrist above the palm, in meters; it is seen and not felt.
const WRIST: [f32; 2] = [0.022, 0.09];

impl World {
    /// Everything that can be seen but the floor, where it really is.
    pub(crate) fn things(&self) -> Vec<Thing> {
        let looks = self.looks.iter().map(|look| self.thing(look));
        looks.chain(std::iter::once(self.hand())).collect()
    }

    fn thing(&self, Look { name, solid, colors }: &Look) -> Thing {
        let (pose, role, colliders) = match solid {
            Solid::Body(body) => {
                let body = &self.state.bodies[*body];
                let role = if body.is_fixed() { Role::Fixed } else { Role::Moving };
                (isometry(body.position()), role, body.colliders())
            }
            Solid::Ground(collider) => {
                let pose = isometry(self.state.colliders[*collider].position());
                (pose, Role::Fixed, std::slice::from_ref(collider))
            }
        };
        let paint = colors.iter().chain(colors.last().into_iter().cycle());
        let shapes = colliders.iter().zip(paint);
        let shapes = shapes.filter_map(|(collider, color)| {
            let collider = &self.state.colliders[*collider];
            let (form, turn) = form(collider)?;
            let place = collider.position_wrt_parent().map_or(Isometry3::identity(), isometry);
            Some(Shape { form, pose: place * turn, color: *color })
        });
        Thing { name: name.clone(), role, pose, shapes: shapes.collect() }
    }

    /// What holds the fingers.
    fn hand(&self) -> Thing {
        let grip = self.state.gripper.grip(&self.state.bodies);
        let [radius, height] = WRIST;
        let palm = self.state.gripper.top() + PALM_HALF.z;
        let wrist = palm + PALM_HALF.z + height / 2.0;
        let shape =
            |form, z| Shape { form, pose: Isometry3::translation(0.0, 0.0, z), color: HAND };
        Thing {
            name: "hand".to_owned(),
            role: Role::Moving,
            pose: Isometry3::from(grip.position.coords),
            shapes: vec![
                shape(Form::Box(PALM_HALF), palm),
                shape(Form::Cylinder { radius, height }, wrist),
            ],
        }
    }
}

/// The form of a collider, and how it is turned: the axis of Rapier's cylinders is y.
fn form(collider: &Collider) -> Option<(Form, UnitQuaternion<f32>)> {
    let shape = collider.shape();
    if let Some(cuboid) = shape.as_cuboid() {
        return Some((Form::Box(nalgebra(cuboid.half_extents)), UnitQuaternion::identity()));
    }
    let cylinder = shape.as_cylinder()?;
    let form = Form::Cylinder { radius: cylinder.radius, height: 2.0 * cylinder.half_height };
    Some((form, UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2)))
}

fn isometry(pose: &Pose) -> Isometry3<f32> {
    let [x, y, z, w] = pose.rotation.to_array();
    Isometry3::from_parts(
        Translation3::from(nalgebra(pose.translation)),
        UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
    )
}
