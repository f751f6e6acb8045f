//! Evaluation is judged by the last frame: episodes that go by a script, whatever the actions.

use crate::toy::small;
use insta::assert_snapshot;
use rher_core::config::{EvaluationConfig, Method, TestPolicy};
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::evaluate::{Evaluation, Played, evaluate, play};
use rher_core::explore::ActionSource;
use rher_core::goal::{Achieved, Desired, Position, Scene, Stage, Tolerances};
use rher_core::policy::Policy;
use rher_core::seed::{Purpose, Seed};
use rher_core::train::Trainer;
use std::array;
use std::fmt::Write as _;

/// Three objects in a row, 1 m apart; their targets are 1 m further along y.
///
/// A frame is a letter for each object and one for the gripper:
///
/// | letter | meaning                                      |
/// |--------|----------------------------------------------|
/// | `x`    | in its place                                 |
/// | `o`    | 4 cm from its place                          |
/// | `-`    | where it started                             |
/// | `m`    | moved by 2 cm from where it started          |
/// | `n`    | moved by 8 mm from where it started          |
/// | `b`    | moved by 1 cm, the boundary                  |
/// | `1`    | the gripper is at object 1, and so on        |
/// | `0`    | the gripper is at no object                  |
#[derive(Clone)]
struct Scripted {
    spec: EnvSpec<3>,
    frames: Vec<Achieved<3>>,
    step: usize,
    truth: Option<Achieved<3>>,
}

fn target(object: usize) -> Position {
    Position::new(object as f32, 1.0, 0.0)
}

fn frame(letters: &str) -> Achieved<3> {
    let letters = letters.as_bytes();
    let objects = array::from_fn(|object| {
        let y = match letters[object] {
            b'x' => 1.0,
            b'o' => 0.96,
            b'm' => 0.02,
            b'n' => 0.008,
            b'b' => 0.01,
            b'-' => 0.0,
            other => panic!("{other} is no letter of a frame"),
        };
        Position::new(object as f32, y, 0.0)
    });
    let gripper = match letters[3] {
        b'0' => Position::new(0.0, 0.0, 1.0),
        object => objects[usize::from(object - b'1')],
    };
    Achieved(Scene::new(gripper, objects))
}

fn scripted(frames: &str) -> Scripted {
    let frames: Vec<Achieved<3>> = frames.split_whitespace().map(frame).collect();
    Scripted {
        spec: EnvSpec {
            // What is 4 cm away is in its place for the first object alone.
            tolerances: Tolerances {
                gripper: 0.03,
                objects: [0.05, 0.03, 0.02],
                ..Tolerances::uniform(0.0)
            },
            ..EnvSpec::new("scripted", 1, 1, frames.len() - 1)
        },
        frames,
        step: 0,
        truth: None,
    }
}

impl Env<3> for Scripted {
    fn spec(&self) -> &EnvSpec<3> {
        &self.spec
    }

    fn reset(&mut self, _seed: u64, observation: &mut [f32]) -> Result<Start<3>, EnvError> {
        self.step = 0;
        observation[0] = 0.0;
        let desired = Desired::of_task(array::from_fn(target));
        Ok(Start { achieved: self.frames[0], desired })
    }

    fn step(&mut self, _action: &[f32], observation: &mut [f32]) -> Result<Achieved<3>, EnvError> {
        self.step += 1;
        observation[0] = self.step as f32;
        Ok(self.frames[self.step])
    }

    fn truth(&mut self) -> Option<Achieved<3>> {
        self.truth
    }
}

/// A policy that was never trained.
fn policy(env: &Scripted, method: Method) -> Policy {
    let mut config = small("scripted", 3);
    config.relay.method = method;
    Trainer::new(config, vec![env.clone()], 1).unwrap().policy().clone()
}

fn evaluated(env: &Scripted, method: Method, test_policy: TestPolicy) -> Evaluation {
    let config =
        EvaluationConfig { every_episodes: 1, episodes: 2, subtask_episodes: 1, env_seed: 0 };
    evaluate(&mut [env.clone()], &policy(env, method), &config, test_policy).unwrap()
}

/// One line for each script: which of the six sub-tasks succeed.
fn table(scripts: &[&str]) -> String {
    let mut table = String::new();
    for script in scripts {
        let success = evaluated(&scripted(script), Method::Rher, TestPolicy::Final).success;
        let success: String =
            success.iter().map(|rate| if *rate == Some(1.0) { " yes" } else { "   -" }).collect();
        writeln!(table, "{script:<26}{success}").unwrap();
    }
    table
}

#[test]
fn what_counts_is_the_last_frame() {
    let scripts = [
        "---0 ---0 ---0 ---0 ---0",
        "---0 ---0 ---0 ---0 xxx0",
        "---0 ---0 ---0 xxx0 ---0",
        "---0 xxx0 xxx0 ---0 ---0",
        "xxx0 ---0 ---0 ---0 ---0",
        "xxx0 xxx0 xxx0 xxx0 ---0",
        "xxx0 xxx0 xxx0 xxx0 xxx0",
    ];
    assert_snapshot!(table(&scripts), @r"
    ---0 ---0 ---0 ---0 ---0     -   -   -   -   -   -
    ---0 ---0 ---0 ---0 xxx0   yes yes yes yes yes yes
    ---0 ---0 ---0 xxx0 ---0     -   -   -   -   -   -
    ---0 xxx0 xxx0 ---0 ---0     -   -   -   -   -   -
    xxx0 ---0 ---0 ---0 ---0   yes   -   -   -   -   -
    xxx0 xxx0 xxx0 xxx0 ---0   yes   -   -   -   -   -
    xxx0 xxx0 xxx0 xxx0 xxx0     - yes   - yes   - yes
    ");
}

#[test]
fn an_object_counts_with_all_before_it() {
    let scripts = [
        "---0 ---1",
        "---0 x--0",
        "---0 -x-0",
        "---0 xx-0",
        "---0 -xx0",
        "---0 x-x0",
        "---0 xx-3",
        "x--0 x--2",
        "---0 ---2",
        "---0 ---3",
        "o--0 o--2",
        "xo-0 xo-3",
        "xxo0 xxo0",
    ];
    assert_snapshot!(table(&scripts), @r"
    ---0 ---1                  yes   -   -   -   -   -
    ---0 x--0                  yes yes   -   -   -   -
    ---0 -x-0                    -   -   -   -   -   -
    ---0 xx-0                  yes yes yes yes   -   -
    ---0 -xx0                    -   -   -   -   -   -
    ---0 x-x0                  yes yes   -   -   -   -
    ---0 xx-3                  yes yes yes yes yes   -
    x--0 x--2                    - yes yes   -   -   -
    ---0 ---2                    -   -   -   -   -   -
    ---0 ---3                    -   -   -   -   -   -
    o--0 o--2                    - yes yes   -   -   -
    xo-0 xo-3                    - yes   -   -   -   -
    xxo0 xxo0                    - yes   - yes   -   -
    ");
}

/// An object that ends elsewhere than it started was reached, if all before it are in their places.
#[test]
fn an_object_that_was_moved_was_reached() {
    let scripts = [
        "---0 m--0",
        "---0 n--0",
        "---0 b--0",
        "---0 -m-0",
        "x--0 xm-0",
        "o--0 om-0",
        "x--0 xn-0",
        "x--0 -m-0",
        "xx-0 xxm0",
        "xx-0 x-m0",
        "xx-0 -xm0",
        "xo-0 xom0",
        "---0 m--0 ---0",
    ];
    assert_snapshot!(table(&scripts), @r"
    ---0 m--0                  yes   -   -   -   -   -
    ---0 n--0                    -   -   -   -   -   -
    ---0 b--0                    -   -   -   -   -   -
    ---0 -m-0                    -   -   -   -   -   -
    x--0 xm-0                    - yes yes   -   -   -
    o--0 om-0                    - yes yes   -   -   -
    x--0 xn-0                    - yes   -   -   -   -
    x--0 -m-0                  yes   -   -   -   -   -
    xx-0 xxm0                    - yes   - yes yes   -
    xx-0 x-m0                    - yes yes   -   -   -
    xx-0 -xm0                  yes   -   -   -   -   -
    xo-0 xom0                    - yes   -   -   -   -
    ---0 m--0 ---0               -   -   -   -   -   -
    ");
}

#[test]
fn where_the_task_is_to_reach_an_object_moving_it_is_not_enough() {
    let success = |script| {
        let mut env = scripted(script);
        env.spec.subtasks = 3;
        evaluated(&env, Method::Rher, TestPolicy::Final).success_final
    };
    assert_eq!([success("x--0 xm-0"), success("x--0 xm-2")], [0.0, 1.0]);
}

#[test]
fn plain_hindsight_is_evaluated_in_the_last_sub_task_alone() {
    let found = evaluated(&scripted("---0 xxx0"), Method::Her, TestPolicy::Final);
    assert_eq!(found.success, [None, None, None, None, None, Some(1.0)]);
    assert_eq!(found.success_final, 1.0);
}

#[test]
fn distances_are_those_of_the_last_frame() {
    let near = |found: Option<f32>, expected: f32| (found.unwrap() - expected).abs() < 1e-6;
    let mut env = scripted("---0 xxx0 xo-0");
    let found = evaluated(&env, Method::Rher, TestPolicy::Final);
    assert!(near(Some(found.final_distance), (0.04 + 1.0) / 3.0), "{found:?}");
    assert_eq!(found.true_final_distance, None);
    env.truth = Some(frame("oxx0"));
    let found = evaluated(&env, Method::Rher, TestPolicy::Final);
    assert!(near(Some(found.final_distance), (0.04 + 1.0) / 3.0), "{found:?}");
    assert!(near(found.true_final_distance, 0.04 / 3.0), "{found:?}");
    // Where the last sub-task is to reach the second object, it is the gripper's distance to that.
    env.spec.subtasks = 3;
    let found = evaluated(&env, Method::Rher, TestPolicy::Final);
    let apart = gripper_distance(&env.frames[2], 1);
    assert!(near(Some(found.final_distance), apart), "{found:?}");
}

fn gripper_distance(Achieved(scene): &Achieved<3>, object: usize) -> f32 {
    let apart = scene.gripper - scene.objects[object];
    (apart.x * apart.x + apart.y * apart.y + apart.z * apart.z).sqrt()
}

/// A script that goes through every stage.
const RELAY: &str = "---0 ---1 x--0 x--2 xx-0 xx-3 xxx3 xxx0";

fn played(test_policy: TestPolicy, subtask: usize, episode: u64) -> Played<3> {
    let mut env = scripted(RELAY);
    let policy = policy(&env, Method::Rher);
    let stage = Stage::from_index(subtask).unwrap();
    play(&mut env, &policy, stage, test_policy, Seed(5), episode).unwrap()
}

/// The sub-tasks whose policies act in an evaluation of each sub-task, counted from 1.
fn acting(test_policy: TestPolicy) -> String {
    let mut table = String::new();
    for subtask in 0..6 {
        write!(table, "{}:", subtask + 1).unwrap();
        for stage in played(test_policy, subtask, 0).stages {
            write!(table, " {}", stage.index() + 1).unwrap();
        }
        table.push('\n');
    }
    table
}

#[test]
fn the_policy_under_test_acts_from_start_to_end() {
    assert_snapshot!(acting(TestPolicy::Final), @r"
    1: 1 1 1 1 1 1 1
    2: 2 2 2 2 2 2 2
    3: 3 3 3 3 3 3 3
    4: 4 4 4 4 4 4 4
    5: 5 5 5 5 5 5 5
    6: 6 6 6 6 6 6 6
    ");
}

#[test]
fn the_policy_of_the_stage_acts_up_to_the_sub_task_under_test() {
    assert_snapshot!(acting(TestPolicy::Guide), @r"
    1: 1 1 1 1 1 1 1
    2: 1 2 2 2 2 2 2
    3: 1 2 3 3 3 3 3
    4: 1 2 3 4 4 4 4
    5: 1 2 3 4 5 5 5
    6: 1 2 3 4 5 6 6
    ");
}

#[test]
fn one_of_the_two_acts_with_equal_chances() {
    assert_snapshot!(acting(TestPolicy::Mix), @r"
    1: 1 1 1 1 1 1 1
    2: 1 2 2 2 2 2 2
    3: 1 3 3 3 3 3 3
    4: 1 4 4 4 4 4 4
    5: 1 5 5 4 5 5 5
    6: 1 6 6 4 5 6 6
    ");
    let of_final = (0..200).flat_map(|episode| played(TestPolicy::Mix, 5, episode).stages);
    // Of seven steps, five have a stage before the last.
    let guided = of_final.filter(|stage| stage.index() < 5).count();
    assert!((450..550).contains(&guided), "{guided} of 1000");
}

/// Scenes are scripted, so the action of a sub-task's policy at a step is always the same.
#[test]
fn actions_are_those_of_the_policy_that_acts() {
    let alone: [Played<3>; 6] = array::from_fn(|subtask| played(TestPolicy::Final, subtask, 0));
    let guided = played(TestPolicy::Guide, 5, 0);
    for (step, stage) in guided.stages.iter().enumerate() {
        let expected = alone[stage.index()].episode.actions[step];
        assert_eq!(guided.episode.actions[step], expected);
        let same = alone.iter().filter(|other| other.episode.actions[step] == expected).count();
        assert!(same < 6, "policies differ, so that this shows something");
    }
}

#[test]
fn the_log_of_an_evaluation_says_who_acted() {
    let played = played(TestPolicy::Guide, 3, 7);
    assert_eq!(played.seed, Seed(5).episode(Purpose::Evaluation, 7));
    let log = played.script(7, None);
    assert_eq!((log.number, log.seed), (7, played.seed));
    assert_eq!(log.actions, played.episode.actions);
    let decisions: Vec<_> =
        log.decisions.iter().map(|it| (it.source, it.subtask, it.value)).collect();
    let (guide, learner) = (ActionSource::Guide, ActionSource::Learner);
    let expected = [
        (guide, 0),
        (guide, 1),
        (guide, 2),
        (learner, 3),
        (learner, 3),
        (learner, 3),
        (learner, 3),
    ];
    assert_eq!(decisions, expected.map(|(source, subtask)| (source, subtask, None)));
}
