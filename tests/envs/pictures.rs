//! What a person sees in pictures.

use rher_core::env::Env as _;
use rher_core::goal::Position;
use rher_envs::render::{Camera, Image, Renderer, Viewpoint, scene};
use rher_envs::tasks::{Insert, Push, TPush};
use rher_envs::thing::{Role, Thing};
use rher_envs::{EnvVisitor, Layout, Simulated, Simulation, Task};
use std::num::NonZeroU16;

const WIDTH: usize = 320;
const HEIGHT: usize = 240;

fn renderer() -> Renderer {
    Renderer::new([WIDTH, HEIGHT].map(|pixels| NonZeroU16::new(pixels as u16).unwrap()))
}

/// The camera of Push.
fn camera() -> Camera {
    let mut env = Simulation::<Push, 1>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    let start = env.reset(0, &mut observation).unwrap();
    Viewpoint::Corner.camera(&mut env, &start).unwrap()
}

fn draw(things: &[Thing]) -> Image {
    renderer().draw(&camera(), things)
}

/// Middle of the pixels where one of the three colors is much stronger than the others, and how
/// many there are.
fn blob(image: &Image, channel: usize) -> ([f32; 2], usize) {
    let mut sum = [0.0; 2];
    let mut count = 0;
    for (index, pixel) in image.rgb.as_chunks::<3>().0.iter().enumerate() {
        let others = (0..3).filter(|other| *other != channel).map(|other| pixel[other]);
        if others.max().unwrap().saturating_add(60) < pixel[channel] {
            sum[0] += (index % WIDTH) as f32;
            sum[1] += (index / WIDTH) as f32;
            count += 1;
        }
    }
    (sum.map(|sum| sum / count as f32), count)
}

fn things_with_block_at(block: Position) -> Vec<Thing> {
    let mut env = Simulation::<Push, 1>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    env.arrange(Layout::new([block], [block]), &mut observation).unwrap();
    env.things()
}

#[test]
fn x_goes_to_the_right_y_to_the_left_and_z_up() {
    let at = |x, y, z| {
        let (place, pixels) = blob(&draw(&things_with_block_at(Position::new(x, y, z))), 0);
        assert!(pixels > 150, "{pixels} pixels of a block");
        place
    };
    let [x, y] = at(1.25, 0.65, 0.425);
    assert!(at(1.4, 0.65, 0.425)[0] > x + 20.0);
    assert!(at(1.25, 0.8, 0.425)[0] < x - 20.0);
    assert!(at(1.25, 0.65, 0.525)[1] < y - 20.0);
}

#[test]
fn what_is_nearer_hides_what_is_behind() {
    let eye = camera().eye;
    let block = Position::new(1.3, 0.7, 0.425);
    let ghost = |share: f32| {
        let place = Position::from(block.coords.lerp(&eye.coords, share));
        let mut things = things_with_block_at(block);
        let mut thing = things.iter().find(|thing| thing.name == "block_1").unwrap().clone();
        thing.name = "screen".to_owned();
        thing.pose.translation.vector = place.coords;
        thing.shapes[0].color = [0.1, 0.1, 0.9, 1.0];
        things.push(thing);
        blob(&draw(&things), 0).1
    };
    assert!(ghost(-0.1) > 150, "a block behind hides the block");
    assert!(ghost(0.1) < 20, "a block before it does not hide it");
}

#[test]
fn a_goal_in_a_hole_shines_through() {
    let mut env = Simulation::<Insert, 1>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    let start = env.reset(0, &mut observation).unwrap();
    let camera = Viewpoint::Corner.camera(&mut env, &start).unwrap();
    let mut things = scene(&mut env, &start.achieved, &start.desired);
    let with = renderer().draw(&camera, &things);
    things.retain(|thing| thing.role != Role::Mark);
    let without = renderer().draw(&camera, &things);
    let changed = with.rgb.iter().zip(&without.rgb).filter(|(a, b)| a.abs_diff(**b) > 8).count();
    assert!(changed > 30, "{changed} numbers differ");
}

#[test]
fn a_picture_depends_on_nothing_but_what_is_in_it() {
    let mut env = Simulation::<TPush, 3>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    let start = env.reset(0, &mut observation).unwrap();
    let camera = Viewpoint::Corner.camera(&mut env, &start).unwrap();
    let things = scene(&mut env, &start.achieved, &start.desired);
    let mut used = renderer();
    used.draw(&camera, &things_with_block_at(Position::new(1.2, 0.6, 0.425)));
    let image = used.draw(&camera, &things);
    assert_eq!(image, renderer().draw(&camera, &things));
    for (channel, name) in ["red", "green", "blue"].iter().enumerate() {
        assert!(blob(&image, channel).1 > 100, "the {name} block is not seen");
    }
}

#[test]
fn a_png_file_holds_the_same_colors() {
    let image = draw(&things_with_block_at(Position::new(1.3, 0.7, 0.425)));
    let file = image.png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgb).unwrap();
    assert_eq!((info.width as usize, info.height as usize), (WIDTH, HEIGHT));
    assert_eq!(rgb, image.rgb);
}

#[test]
fn a_world_around_the_eye_is_no_harm() {
    let things = things_with_block_at(Position::new(1.3, 0.7, 0.425));
    for eye in [Position::new(1.3, 0.7, 0.43), Position::new(1.3, 0.4, 0.2)] {
        let camera = Camera { eye, focus: Position::new(1.4, 0.8, 0.5), field_of_view: 1.0 };
        assert_eq!(renderer().draw(&camera, &things).rgb.len(), 3 * WIDTH * HEIGHT);
    }
}

struct PerSecond;

impl EnvVisitor for PerSecond {
    type Output = f64;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> f64 {
        const PICTURES: u32 = 10;
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let start = env.reset(0, &mut observation).unwrap();
        let camera = Viewpoint::Corner.camera(&mut env, &start).unwrap();
        let things = scene(&mut env, &start.achieved, &start.desired);
        let mut renderer = renderer();
        // The best of several rounds of processor time: other programs only slow it down.
        let rounds = (0..4).map(|_| {
            let begin = cpu_time::ThreadTime::now();
            for _ in 0..PICTURES {
                std::hint::black_box(renderer.draw(&camera, &things));
            }
            f64::from(PICTURES) / begin.elapsed().as_secs_f64()
        });
        rounds.fold(0.0, f64::max)
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "an unoptimised build says nothing about speed")]
fn two_hundred_pictures_take_less_than_a_second_of_one_core() {
    for task in [Task::PUSH, Task::DRAWER_BOX] {
        let per_second = task.visit(PerSecond);
        println!("{task}: {per_second:.0} pictures of {WIDTH} by {HEIGHT} per second of one core");
        assert!(per_second > 200.0, "{task}: {per_second:.0} pictures per second");
    }
}
