//! What can be seen in a world.

use nalgebra::Vector3;
use rher_core::env::Env as _;
use rher_core::goal::Position;
use rher_envs::tasks::{Drawer, Push, TPush};
use rher_envs::thing::{Form, Role, Thing, object_color};
use rher_envs::{EnvVisitor, Layout, Options, Simulated, Simulation, Task};
use std::collections::BTreeSet;

struct Look;

impl EnvVisitor for Look {
    type Output = (Vec<Thing>, Vec<Thing>);

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let start = env.reset(3, &mut observation).unwrap();
        (env.things(), env.goals(&start.desired))
    }
}

fn named<'a>(things: &'a [Thing], name: &str) -> &'a Thing {
    things.iter().find(|thing| thing.name == name).unwrap()
}

#[test]
fn every_task_has_a_table_a_hand_and_goals_each_with_a_name_of_its_own() {
    for task in Task::ALL {
        let (things, goals) = task.visit(Look);
        let names: BTreeSet<_> = things.iter().chain(&goals).map(|thing| &thing.name).collect();
        assert_eq!(names.len(), things.len() + goals.len(), "{task}: {names:?}");
        assert_eq!(named(&things, "table").role, Role::Fixed, "{task}");
        assert_eq!(named(&things, "hand").role, Role::Moving, "{task}");
        assert!(goals.iter().all(|goal| goal.role == Role::Mark), "{task}");
        assert!(things.iter().all(|thing| !thing.shapes.is_empty()), "{task}");
    }
}

#[test]
fn things_are_where_objects_are_and_have_their_color() {
    let mut env = Simulation::<TPush, 3>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    let start = env.reset(5, &mut observation).unwrap();
    let mut achieved = start.achieved;
    for _ in 0..20 {
        achieved = env.step(&[0.5, -1.0, 0.0, 0.0], &mut observation).unwrap();
    }
    let (things, goals) = (env.things(), env.goals(&start.desired));
    for (index, place) in achieved.0.objects.iter().enumerate() {
        let block = named(&things, &format!("block_{}", index + 1));
        assert_eq!(block.pose.translation.vector, place.coords);
        assert_eq!(block.shapes[0].color.as_slice(), object_color(index));
        assert_eq!(goals[index].pose.translation.vector, start.desired.objects()[index].coords);
        assert_eq!(goals[index].shapes[0].color[..3], object_color(index)[..3]);
    }
    let hand = named(&things, "hand").pose.translation.vector;
    assert_eq!(hand, achieved.0.gripper.coords);
}

#[test]
fn a_drawer_moves_with_its_handle() {
    let mut env = Simulation::<Drawer, 1>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    let mut at = |open: f32| {
        let mut handle = Position::new(1.376, 0.63, 0.45);
        handle.x -= open;
        env.arrange(Layout::new([handle], [handle]), &mut observation).unwrap();
        let things = env.things();
        (named(&things, "drawer").pose.translation.x, named(&things, "cabinet").pose)
    };
    let (closed, open) = (at(0.0), at(0.1));
    assert!((closed.0 - open.0 - 0.1).abs() < 1e-6);
    assert_eq!(closed.1, open.1);
}

#[test]
fn a_block_of_another_size_is_seen_so() {
    let mut options = Options::of(&[]);
    options.randomize.size = [1.2, 1.2];
    let mut env = Simulation::<Push, 1>::with(&options).unwrap();
    let mut observation = vec![0.0; env.spec().obs_dim];
    env.reset(0, &mut observation).unwrap();
    let things = env.things();
    let Form::Box(half) = named(&things, "block_1").shapes[0].form else { panic!("not a box") };
    assert!((half - Vector3::repeat(0.03)).amax() < 1e-6, "{half}");
}

#[test]
fn cylinders_stand_upright() {
    let (things, _) = Task::SLIDE.visit(Look);
    let puck = &named(&things, "puck").shapes[0];
    assert_eq!(puck.form, Form::Cylinder { radius: 0.025, height: 0.04 });
    assert!((puck.pose * Vector3::z()).z.abs() > 0.999);
}
