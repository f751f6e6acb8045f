//! What the numbers of observations and actions are called.

use rher_core::Names;
use rher_envs::{EnvVisitor, OptionValue, Options, Simulated, Task};
use std::collections::BTreeSet;

fn names(task: Task) -> Names {
    task.names(&Options::of(task.options())).unwrap()
}

#[test]
fn every_number_of_a_task_has_a_name_of_its_own() {
    for task in Task::ALL {
        task.visit(Named);
    }
}

struct Named;

impl EnvVisitor for Named {
    type Output = ();

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) {
        let env = build();
        let spec = env.spec();
        let Names { objects, observation, action, .. } = &spec.names;
        let lists = [(objects, N), (observation, spec.obs_dim), (action, spec.action_dim)];
        for (list, expected) in lists {
            let different: BTreeSet<&String> = list.iter().collect();
            assert_eq!((list.len(), different.len()), (expected, expected), "{}", spec.name);
        }
        // Where the positions of gripper and objects are, two lists must agree.
        let places = env.places();
        let objects = objects.iter().zip(places.objects);
        for (owner, place) in [(&"gripper".to_owned(), places.gripper)].into_iter().chain(objects) {
            if let Some(place) = place {
                let expected = ["x", "y", "z"].map(|axis| format!("{owner}.position.{axis}"));
                assert_eq!(observation[place..place + 3], expected, "{}", spec.name);
            }
        }
    }
}

#[test]
fn objects_that_trade_places_trade_names() {
    let counts = Task::ALL.iter().map(|task| task.visit(Traded)).filter(|count| *count > 0);
    assert_eq!(counts.collect::<Vec<_>>(), [1, 1, 5, 5]);
}

struct Traded;

impl EnvVisitor for Traded {
    /// Orders besides the objects' own.
    type Output = usize;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> usize {
        let env = build();
        let spec = env.spec();
        let Names { objects, observation, .. } = &spec.names;
        for exchange in &spec.permutations {
            for (name, image) in observation.iter().zip(&exchange.observation) {
                let mut expected = name.clone();
                // By way of names that nothing has, since two objects take each other's.
                for (place, object) in objects.iter().enumerate() {
                    expected = expected.replace(object, &format!("<{place}>"));
                }
                for (place, object) in exchange.order.iter().enumerate() {
                    expected = expected.replace(&format!("<{place}>"), &objects[*object]);
                }
                if image.sign < 0.0 {
                    let (one, rest) = expected.split_once(".from_").unwrap();
                    let (other, axis) = rest.split_once('.').unwrap();
                    expected = format!("{other}.from_{one}.{axis}");
                }
                assert_eq!(observation[image.from], expected, "{}: {name}", spec.name);
            }
        }
        spec.permutations.len()
    }
}

#[test]
fn what_a_small_task_has_a_larger_one_has_too() {
    let chains = [
        [Task::PUSH, Task::DPUSH],
        [Task::DPUSH, Task::TPUSH],
        [Task::PICK, Task::STACK],
        [Task::STACK, Task::TSTACK],
    ];
    for [small, large] in chains {
        let [small_names, large_names] = [small, large].map(names);
        assert_eq!(small_names.action, large_names.action, "{small} and {large}");
        let missing: Vec<&String> = small_names
            .observation
            .iter()
            .filter(|name| !large_names.observation.contains(name))
            .collect();
        // A tower's observation does not have what is between its blocks.
        let between = large == Task::TSTACK;
        let expected: Vec<String> =
            ["x", "y", "z"].map(|axis| format!("block1.from_block2.{axis}")).into();
        assert_eq!(missing, expected.iter().filter(|_| between).collect::<Vec<_>>(), "{large}");
    }
}

#[test]
fn what_is_not_the_same_has_another_name() {
    let object = |task: Task| names(task).objects[0].clone();
    let tasks = [
        (Task::PUSH, "block1"),
        (Task::SLIDE, "puck1"),
        (Task::REACH, "target1"),
        (Task::INSERT, "hole1"),
        (Task::DRAWER, "handle1"),
        (Task::CUE_PUSH, "cylinder1"),
    ];
    for (task, name) in tasks {
        assert_eq!(object(task), name, "{task}");
    }
    assert_eq!(names(Task::DRAWER_BOX).objects, ["handle1", "block2"]);

    // A locked hand, a free one and a cue.
    let hands = [Task::PUSH, Task::PICK, Task::CUE_PUSH].map(|task| names(task).action);
    assert!(hands[0] != hands[1] && hands[1] != hands[2] && hands[0] != hands[2]);

    // Numbers that are there twice.
    let twice = names(Task::TPUSH).observation[64..].to_vec();
    let expected = ["gripper.velocity.x", "gripper.velocity.y", "gripper.velocity.z"];
    let expected = expected.into_iter().chain(["finger1.velocity", "finger2.velocity"]);
    assert_eq!(twice, expected.map(|name| format!("{name}#2")).collect::<Vec<_>>());

    // Zeros in place of an obstacle that is not shown.
    let mut options = Options::of(Task::OBSTACLE_PUSH.options());
    options.task.0.insert("observe_obstacle".to_owned(), OptionValue::Flag(false));
    let [shown, hidden] =
        [names(Task::OBSTACLE_PUSH), Task::OBSTACLE_PUSH.names(&options).unwrap()];
    assert_eq!(shown.observation[25], "obstacle.from_gripper.x");
    assert!(!hidden.observation.contains(&shown.observation[25]));
}
