//! Every camera has the hand, the objects and their goals in its picture.

use crate::support::towards;
use nalgebra::Vector3;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use rher_core::goal::{Achieved, Desired, Position};
use rher_envs::render::{Camera, Image, Renderer, Viewpoint, scene};
use rher_envs::thing::{Role, Thing, object_color};
use rher_envs::{EnvVisitor, Simulated, Task};
use std::num::NonZeroU16;

const EPISODES: u64 = 200;

const SIZE: [usize; 2] = [160, 120];

/// Half the edges of what is looked for around an object's middle and around a goal, in meters.
const OBJECT: Vector3<f32> = Vector3::new(0.025, 0.025, 0.02);

/// How far above what it visits a hand stays, in meters.
const ABOVE: f32 = 0.07;

/// What the caption covers of the height of a picture.
const CAPTION: f32 = 0.07;

/// Whether a camera has a box around a place in its picture, below its caption.
fn sees(camera: &Camera, place: &Position, half: Vector3<f32>) -> bool {
    let forward = (camera.focus - camera.eye).normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let down = forward.cross(&right);
    let half_height = libm::tanf(camera.field_of_view / 2.0);
    (0..8).all(|corner| {
        let sign = |axis: usize| if corner >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let offset = Vector3::new(half.x * sign(0), half.y * sign(1), half.z * sign(2));
        let seen = place + offset - camera.eye;
        let high = half_height * seen.dot(&forward);
        let (x, y) = (seen.dot(&right) / (high * 4.0 / 3.0), seen.dot(&down) / high);
        high > 0.0 && x.abs() <= 1.0 && (2.0 * CAPTION - 1.0..=1.0).contains(&y)
    })
}

/// Whether a camera has all that matters in its picture: the fingers or the cue, objects and goals.
fn sees_all<const N: usize>(
    camera: &Camera,
    Achieved(now): &Achieved<N>,
    desired: &Desired<N>,
) -> bool {
    let finger = Vector3::new(0.0135, 0.0135, 0.02);
    let places = now.objects.iter().chain(desired.objects());
    sees(camera, &now.gripper, finger) && places.into_iter().all(|it| sees(camera, it, OBJECT))
}

/// How often cameras see all that matters, and what of it is hidden.
struct Measure;

#[derive(Debug)]
struct Seen {
    /// Of episodes as they begin, by viewpoint.
    beginnings: [f64; Viewpoint::ALL.len()],
    /// Of steps from the first viewpoint: a hand that visits every object and every goal, and one
    /// that moves at random.
    visits: f64,
    random: f64,
    /// How much of each object, and of the ghost at its goal, other things hide from the first
    /// viewpoint: the mean over beginnings; `None` where there is nothing to hide.
    hidden: Vec<[Option<f64>; 2]>,
}

impl EnvVisitor for Measure {
    type Output = Seen;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Seen {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let start = env.reset(0, &mut observation).unwrap();
        // All but the last one are the same in every episode.
        let fixed = Viewpoint::ALL
            .map(|viewpoint| (viewpoint, viewpoint.camera(&mut env, &start).unwrap()));
        let steps = env.spec().episode_steps;
        let width = env.spec().action_dim;
        let mut beginnings = [0_u64; Viewpoint::ALL.len()];
        let mut walked = [[0_u64; 2]; 2];
        let mut hidden = vec![[Vec::new(), Vec::new()]; N];
        for seed in 0..EPISODES {
            let start = env.reset(seed, &mut observation).unwrap();
            let cameras = fixed.map(|(viewpoint, camera)| match viewpoint {
                Viewpoint::Close => viewpoint.camera(&mut env, &start).unwrap(),
                _ => camera,
            });
            for (camera, count) in cameras.iter().zip(&mut beginnings) {
                *count += u64::from(sees_all(camera, &start.achieved, &start.desired));
            }
            let [camera, ..] = cameras;
            let things = scene(&mut env, &start.achieved, &start.desired);
            for (index, hidden) in hidden.iter_mut().enumerate().filter(|_| seed % 4 == 0) {
                let ghost = format!("ghost_{}", index + 1);
                hidden[0].extend(share_hidden(&camera, &things, |thing, color| {
                    thing.role != Role::Mark && color.as_slice() == object_color(index)
                }));
                hidden[1].extend(share_hidden(&camera, &things, |thing, _| thing.name == ghost));
            }
            if seed % 10 != 0 {
                continue;
            }
            for (is_random, count) in [false, true].into_iter().zip(&mut walked) {
                let Achieved(mut now) = env.reset(seed, &mut observation).unwrap().achieved;
                for step in 0..steps {
                    let stop = step * 2 * N / steps;
                    let wanted = match stop % 2 {
                        0 => now.objects[stop / 2],
                        _ => start.desired.objects()[stop / 2],
                    };
                    let above = wanted + Vector3::z() * ABOVE;
                    let mut action = towards(above, now.gripper, 1.0);
                    if is_random {
                        action = action.map(|_| rng.random_range(-1.0..1.0));
                    }
                    Achieved(now) = env.step(&action[..width], &mut observation).unwrap();
                    let is_seen = sees_all(&camera, &Achieved(now), &start.desired);
                    *count = [count[0] + u64::from(is_seen), count[1] + 1];
                }
            }
        }
        let share = |[count, of]: [u64; 2]| count as f64 / of as f64;
        let mean = |shares: Vec<f64>| {
            (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
        };
        Seen {
            beginnings: beginnings.map(|count| share([count, EPISODES])),
            visits: share(walked[0]),
            random: share(walked[1]),
            hidden: hidden.into_iter().map(|both| both.map(mean)).collect(),
        }
    }
}

/// How much of the chosen shapes other things hide; `None` if no shape is chosen.
fn share_hidden(
    camera: &Camera,
    things: &[Thing],
    is_chosen: impl Fn(&Thing, [f32; 4]) -> bool,
) -> Option<f64> {
    const CHOSEN: [f32; 4] = [1.0, 0.0, 1.0, 1.0];
    const OTHERS: [f32; 4] = [0.0, 0.0, 0.0, 1.0];
    let mut all = Vec::new();
    let mut alone = Vec::new();
    for thing in things {
        let mut chosen = thing.clone();
        chosen.role = Role::Moving;
        chosen.shapes.retain(|shape| is_chosen(thing, shape.color));
        chosen.shapes.iter_mut().for_each(|shape| shape.color = CHOSEN);
        let mut others = thing.clone();
        others.shapes.retain(|shape| !is_chosen(thing, shape.color));
        others.shapes.iter_mut().for_each(|shape| shape.color = OTHERS);
        if !chosen.shapes.is_empty() {
            alone.push(chosen.clone());
            all.push(chosen);
        }
        if thing.role != Role::Mark && !others.shapes.is_empty() {
            all.push(others);
        }
    }
    let mut renderer = Renderer::new(SIZE.map(|pixels| NonZeroU16::new(pixels as u16).unwrap()));
    let count = |image: &Image| {
        let is_chosen = |[r, g, b]: &&[u8; 3]| *r > 40 && *b > 40 && *g < 20;
        image.rgb.as_chunks::<3>().0.iter().filter(is_chosen).count() as f64
    };
    let of = count(&renderer.draw(camera, &alone));
    (of > 0.0).then(|| 1.0 - (count(&renderer.draw(camera, &all)) / of).min(1.0))
}

#[test]
fn hand_objects_and_goals_are_in_the_picture() {
    Task::ALL.par_iter().for_each(|task| {
        let seen = task.visit(Measure);
        println!("{task}: {seen:.2?}");
        for (viewpoint, share) in Viewpoint::ALL.iter().zip(seen.beginnings) {
            assert!(share > 0.98, "{task}, {}: {share} of beginnings", viewpoint.name());
        }
        assert!(seen.visits > 0.97, "{task}: {} of steps of visits", seen.visits);
        assert!(seen.random > 0.8, "{task}: {} of random steps", seen.random);
        for (index, [object, goal]) in seen.hidden.into_iter().enumerate() {
            // A block in a closed drawer cannot be seen, and a goal in a hole shines through.
            let is_inside = (task.name(), index) == ("drawer-box", 1);
            let object = object.filter(|_| !is_inside).unwrap_or(0.0);
            assert!(object < 0.3, "{task}: {object} of object {} is hidden", index + 1);
            let goal = goal.filter(|_| task.name() != "insert").unwrap_or(0.0);
            assert!(goal < 0.35, "{task}: {goal} of goal {} is hidden", index + 1);
        }
    });
}
