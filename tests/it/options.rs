//! Settings of a task's scenes: set, written down, and applied again.

use crate::support::{Rher, TINY};
use insta::assert_snapshot;
use serde_json::Value;

#[test]
fn options_go_through_files_and_set() {
    let rher = Rher::new();
    rher.write("run.toml", "[task]\nname = \"obstacle-push\"\nobserve_obstacle = false\n");
    let printed = rher.ok("config obstacle-push --config run.toml --set randomize.mass=[0.5,2]");
    assert!(printed.contains("\nname = \"obstacle-push\"\n"), "{printed}");
    assert!(printed.contains("\nobserve_obstacle = false\n"), "{printed}");
    assert!(printed.contains("\nmass = [0.5, 2.0]\n"), "{printed}");
    rher.write("again.toml", &printed);
    assert_eq!(rher.ok("config obstacle-push --config again.toml"), printed);
}

#[test]
fn options_that_do_not_fit_are_told() {
    let rher = Rher::new();
    let set =
        |task: &str, setting: &str| rher.run(&format!("train {task} --set {setting}")).to_string();
    assert_snapshot!(set("push", "task.observe_obstacle=false"), @"
    exit 2
    error: --set: `task.observe_obstacle` is a setting of `obstacle-push`, not of `push`

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(set("obstacle-push", "task.observe_obstacles=false"), @"
    exit 2
    error: --set: there is no setting `task.observe_obstacles`

    hint: did you mean `task.observe_obstacle`? `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(set("obstacle-push", "task.observe_obstacle=2"), @"
    exit 2
    error: --set: `task.observe_obstacle` is 2, expected true or false

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(set("cue-push", "task.delay=0.5"), @"
    exit 2
    error: --set: `task.delay` is 0.5, expected a whole number from 0 to 8

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(set("push", "randomize.mass=[2,1]"), @"
    exit 2
    error: --set: `randomize.mass` is [2, 1], expected [low, high] with 0.2 ≤ low ≤ high ≤ 5

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(set("push", "randomize.friction=2"), @"
    exit 2
    error: --set: `randomize.friction` is 2, expected [low, high] with 0.2 ≤ low ≤ high ≤ 3

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(set("push", "task.name=pick"), @"
    exit 2
    error: `task.name` cannot be changed by --set

    hint: give the task itself, as in `rher train push`
    ");
}

#[test]
fn a_resumed_run_and_an_evaluation_have_the_options_of_the_run() {
    let rher = Rher::new();
    let options = "--set task.observe_obstacle=false --set randomize.mass=[0.5,2] \
                   --set randomize.sensor_noise=[0.001,0.003] --set randomize.action_delay=[0,1]";
    let run = |steps: usize, out: &str| {
        format!("train obstacle-push --quiet --env-steps {steps} {TINY} {options} --out {out}")
    };
    rher.ok(&run(1000, "straight"));
    rher.ok(&run(500, "resumed"));
    rher.ok("train --quiet --resume resumed --env-steps 1000");
    assert_eq!(rher.metrics("resumed"), rher.metrics("straight"));
    let config = |run: &str| std::fs::read_to_string(rher.path(run).join("config.toml")).unwrap();
    assert_eq!(config("resumed"), config("straight"));
    assert!(config("resumed").contains("observe_obstacle = false"));

    let plain = "train obstacle-push --quiet --env-steps 500";
    rher.ok(&format!("{plain} {TINY} --out plain"));
    let eval = |path: &str| -> Value {
        serde_json::from_str(&rher.ok(&format!("eval {path} --episodes 5 --json"))).unwrap()
    };
    // Sensors are noisy in the one and not in the other.
    assert!(eval("resumed/policy.safetensors")["true_final_distance"].is_f64());
    assert!(eval("plain/policy.safetensors")["true_final_distance"].is_null());
}

#[test]
fn with_a_camera_the_true_distance_is_told() {
    let rher = Rher::new();
    rher.ok(&format!("train cue-push --quiet --env-steps 200 {TINY} --out run"));
    let told = rher.ok("eval run --episodes 5");
    assert!(told.contains("\ntrue distance"), "{told}");
}
