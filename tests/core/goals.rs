//! The slot rule as tables that a person can check against the paper, and the stages around it.

use insta::assert_snapshot;
use rher_core::goal::{
    Achieved, Desired, EncodedGoal, LaterObjects, Leg, Position, Scene, Stage, Tolerances,
};
use std::fmt::Write as _;

/// A scene in which every position is told apart by its x: the gripper's is `base`, object i's is
/// `base + i`.
fn scene<const N: usize>(base: f32) -> Scene<N> {
    let at = |x| Position::new(x, 0.0, 0.0);
    let mut objects = [at(base); N];
    for (index, object) in objects.iter_mut().enumerate() {
        object.x += index as f32 + 1.0;
    }
    Scene::new(at(base), objects)
}

/// One line for each sub-task: where each slot's position comes from.
fn table<const N: usize>(desired: &Desired<N>) -> String {
    let now = Achieved(scene::<N>(0.0));
    let mut table = String::new();
    for stage in Stage::all() {
        let leg = match stage.leg() {
            Leg::Reach => "reach",
            Leg::Place => "place",
        };
        write!(table, "{leg} {}:", stage.object() + 1).unwrap();
        for slot in EncodedGoal::new(stage, &now, desired).slots() {
            let source = match slot.map(|position| position.x as i32) {
                None => "blank".to_owned(),
                Some(0) => "gripper now".to_owned(),
                Some(object @ 1..=9) => format!("object {object} now"),
                Some(object @ 11..=19) => format!("target {}", object - 10),
                Some(20) => "gripper later".to_owned(),
                Some(object) => format!("object {} later", object - 20),
            };
            write!(table, " {source:<15}").unwrap();
        }
        table.truncate(table.trim_end().len());
        table.push('\n');
    }
    table
}

fn asked<const N: usize>() -> Desired<N> {
    Desired::of_task(scene::<N>(10.0).objects)
}

fn hindsight<const N: usize>(later_objects: LaterObjects) -> Desired<N> {
    Desired::in_hindsight(Achieved(scene::<N>(20.0)), later_objects)
}

#[test]
fn goals_of_the_task_with_one_object() {
    assert_snapshot!(table(&asked::<1>()), @r"
    reach 1: object 1 now    blank
    place 1: blank           target 1
    ");
}

#[test]
fn goals_of_the_task_with_two_objects() {
    assert_snapshot!(table(&asked::<2>()), @r"
    reach 1: object 1 now    blank           object 2 now
    place 1: blank           target 1        object 2 now
    reach 2: object 2 now    target 1        blank
    place 2: blank           target 1        target 2
    ");
}

#[test]
fn goals_of_the_task_with_three_objects() {
    assert_snapshot!(table(&asked::<3>()), @r"
    reach 1: object 1 now    blank           object 2 now    object 3 now
    place 1: blank           target 1        object 2 now    object 3 now
    reach 2: object 2 now    target 1        blank           object 3 now
    place 2: blank           target 1        target 2        object 3 now
    reach 3: object 3 now    target 1        target 2        blank
    place 3: blank           target 1        target 2        target 3
    ");
}

#[test]
fn goals_in_hindsight_with_one_object() {
    assert_snapshot!(table(&hindsight::<1>(LaterObjects::Now)), @r"
    reach 1: gripper later   blank
    place 1: blank           object 1 later
    ");
}

#[test]
fn goals_in_hindsight_with_two_objects() {
    assert_snapshot!(table(&hindsight::<2>(LaterObjects::Now)), @r"
    reach 1: gripper later   blank           object 2 now
    place 1: blank           object 1 later  object 2 now
    reach 2: gripper later   object 1 later  blank
    place 2: blank           object 1 later  object 2 later
    ");
}

#[test]
fn goals_in_hindsight_with_three_objects_as_the_code_has_them() {
    assert_snapshot!(table(&hindsight::<3>(LaterObjects::Now)), @r"
    reach 1: gripper later   blank           object 2 now    object 3 now
    place 1: blank           object 1 later  object 2 now    object 3 now
    reach 2: gripper later   object 1 later  blank           object 3 now
    place 2: blank           object 1 later  object 2 later  object 3 now
    reach 3: gripper later   object 1 later  object 2 later  blank
    place 3: blank           object 1 later  object 2 later  object 3 later
    ");
}

#[test]
fn goals_in_hindsight_with_three_objects_as_the_paper_has_them() {
    assert_snapshot!(table(&hindsight::<3>(LaterObjects::Later)), @r"
    reach 1: gripper later   blank           object 2 later  object 3 later
    place 1: blank           object 1 later  object 2 later  object 3 later
    reach 2: gripper later   object 1 later  blank           object 3 later
    place 2: blank           object 1 later  object 2 later  object 3 later
    reach 3: gripper later   object 1 later  object 2 later  blank
    place 3: blank           object 1 later  object 2 later  object 3 later
    ");
}

#[test]
fn a_stage_goes_by_the_first_object_that_is_not_placed() {
    let tolerances = Tolerances::uniform(0.05);
    let desired = asked::<3>();
    let stage = |scene: &Scene<3>| Stage::of(&Achieved(*scene), &desired, &tolerances, 0.03);
    let mut now = scene::<3>(0.0);
    assert_eq!(stage(&now).index(), 0, "far from the first object");
    now.gripper = now.objects[0];
    assert_eq!(stage(&now).index(), 1, "at the first object");
    now.objects[0] = desired.objects()[0];
    assert_eq!(stage(&now).index(), 2, "the first object is placed");
    now.gripper = now.objects[1];
    assert_eq!(stage(&now).index(), 3, "at the second object");
    now.objects[0].y += 0.06;
    assert_eq!(stage(&now).index(), 0, "the first object was disturbed");
    now.objects = *desired.objects();
    now.gripper = now.objects[2];
    assert_eq!(stage(&now).index(), 5, "all are placed: the last object counts");
}

#[test]
fn stages_count_up_in_relay_order() {
    let all: Vec<_> = Stage::<3>::all().map(|s| (s.object(), s.leg())).collect();
    let legs = [Leg::Reach, Leg::Place];
    let expected: Vec<_> = (0..3).flat_map(|object| legs.map(|leg| (object, leg))).collect();
    assert_eq!(all, expected);
    for stage in Stage::<3>::all() {
        assert_eq!(Stage::from_index(stage.index()), Some(stage));
    }
    assert_eq!(Stage::<3>::from_index(6), None);
}

#[test]
fn every_slot_that_is_not_blank_must_be_met() {
    let tolerances = Tolerances::uniform(0.05);
    let desired = asked::<2>();
    let stage = Stage::<2>::from_index(2).unwrap();
    let mut now = scene::<2>(0.0);
    now.objects[0] = desired.objects()[0];
    now.gripper = now.objects[1];
    let goal = EncodedGoal::new(stage, &Achieved(now), &desired);
    assert_eq!(goal.reward(&Achieved(now), &tolerances), 0.0);
    let mut first_object_left = now;
    first_object_left.objects[0].y += 0.051;
    assert_eq!(goal.reward(&Achieved(first_object_left), &tolerances), -1.0);
    let mut gripper_left = now;
    gripper_left.gripper.y += 0.051;
    assert_eq!(goal.reward(&Achieved(gripper_left), &tolerances), -1.0);
    let mut within = now;
    within.gripper.y += 0.049;
    assert_eq!(goal.reward(&Achieved(within), &tolerances), 0.0);
}

#[test]
fn a_goal_has_a_slot_for_the_gripper_and_for_every_object() {
    let slots = |goal: EncodedGoal<3>| goal.slots().count();
    let goal = EncodedGoal::new(Stage::FIRST, &Achieved(scene::<3>(0.0)), &asked::<3>());
    assert_eq!((slots(goal), EncodedGoal::<3>::SLOTS), (4, 4));
}
