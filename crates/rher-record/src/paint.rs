//! Things as Foxglove's frames and entities.

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, Duration, FrameTransform, Pose, Quaternion,
    SceneEntity, SpherePrimitive, Timestamp, Vector3,
};
use nalgebra::Isometry3;
use rher_envs::thing::{self, Form, Shape, Thing};

/// The root of all frames.
pub(crate) const ROOT: &str = "world";

const NANOSECONDS: u64 = 1_000_000_000;

/// Where a thing is: a frame of its name.
pub(crate) fn transform(thing: &Thing, time: u64) -> FrameTransform {
    let (translation, rotation) = parts(&thing.pose);
    FrameTransform {
        timestamp: Some(timestamp(time)),
        parent_frame_id: ROOT.to_owned(),
        child_frame_id: thing.name.clone(),
        translation: Some(translation),
        rotation: Some(rotation),
    }
}

/// What a thing looks like, in its own frame; there until it is replaced.
pub(crate) fn entity(thing: &Thing, time: u64) -> SceneEntity {
    let mut entity = SceneEntity {
        timestamp: Some(timestamp(time)),
        frame_id: thing.name.clone(),
        id: thing.name.clone(),
        lifetime: Some(Duration::new(0, 0)),
        frame_locked: true,
        ..SceneEntity::default()
    };
    for Shape { form, pose, color } in &thing.shapes {
        let (position, orientation) = parts(pose);
        let pose = Some(Pose { position: Some(position), orientation: Some(orientation) });
        let color = Some(self::color(*color));
        match *form {
            Form::Box(half) => {
                let size = Some(vector(2.0 * half.x, 2.0 * half.y, 2.0 * half.z));
                entity.cubes.push(CubePrimitive { pose, size, color });
            }
            Form::Cylinder { radius, height } => {
                let size = Some(vector(2.0 * radius, 2.0 * radius, height));
                let (bottom_scale, top_scale) = (1.0, 1.0);
                let cylinder = CylinderPrimitive { pose, size, bottom_scale, top_scale, color };
                entity.cylinders.push(cylinder);
            }
            Form::Sphere(radius) => {
                let size = Some(vector(2.0 * radius, 2.0 * radius, 2.0 * radius));
                entity.spheres.push(SpherePrimitive { pose, size, color });
            }
        }
    }
    entity
}

fn timestamp(time: u64) -> Timestamp {
    Timestamp::new((time / NANOSECONDS) as u32, (time % NANOSECONDS) as u32)
}

fn parts(pose: &Isometry3<f32>) -> (Vector3, Quaternion) {
    let (place, turn) = (pose.translation.vector, pose.rotation.coords.cast::<f64>());
    let rotation = Quaternion { x: turn.x, y: turn.y, z: turn.z, w: turn.w };
    (vector(place.x, place.y, place.z), rotation)
}

fn vector(x: f32, y: f32, z: f32) -> Vector3 {
    Vector3 { x: x.into(), y: y.into(), z: z.into() }
}

fn color([r, g, b, a]: thing::Color) -> Color {
    Color { r: r.into(), g: g.into(), b: b.into(), a: a.into() }
}
