//! Datasets, judged by the readers of those whose format they have.

use crate::python::{self, python};
use crate::support::{Rher, TINY};
use serde_json::{Value, json};

/// A run, and a recording of its first three episodes.
fn recorded(task: &str) -> Rher {
    let rher = Rher::new();
    rher.ok(&format!("train {task} --env-steps 1 --out run {TINY}"));
    rher.ok("play run --episodes 3 --mcap out.mcap");
    rher
}

fn parse(text: &str) -> Value {
    serde_json::from_str(text.lines().last().unwrap()).unwrap()
}

#[test]
fn minari_reads_its_datasets() {
    let Some(python) = python() else { return };
    let rher = recorded("tpush");
    rher.ok("export run --format minari --out played --episodes 3");
    rher.ok("export out.mcap --format minari --out recorded");
    let read = |folder: &str| {
        parse(&python::run(python, "minari_dataset.py", &[&rher.path(folder).join("data")]))
    };
    let dataset = read("played");
    assert_eq!(dataset, read("recorded"), "a recording and what it was made of");
    assert_eq!(dataset["id"], "rher/tpush-v0");
    assert_eq!((&dataset["total_episodes"], &dataset["total_steps"]), (&json!(3), &json!(210)));
    let tasks: Value = serde_json::from_str(&rher.ok("tasks --json")).unwrap();
    let tasks = tasks.as_array().unwrap();
    let task = tasks.iter().find(|task| task["name"] == "tpush").unwrap();
    let goals = json!([71, 9]);
    assert_eq!(
        dataset["observations"],
        json!({
            "observation": [71, task["observation"]],
            "achieved_goal": goals,
            "desired_goal": goals,
        })
    );
    assert_eq!(dataset["actions"], json!([70, 4]));
    assert_eq!(dataset["rewards"], json!([70]));
    assert_eq!(dataset["successes"], json!([71]));
    assert_eq!(dataset["truncated_at"], json!([69, 69, 69]));
    assert_eq!((&dataset["terminated"], &dataset["sampled"]), (&json!(false), &json!(2)));
}

#[test]
fn reaching_is_about_the_gripper() {
    let Some(python) = python() else { return };
    let rher = recorded("reach");
    rher.ok("export run --format minari --out played --episodes 3");
    let data = rher.path("played/data");
    let dataset = parse(&python::run(python, "minari_dataset.py", &[&data]));
    assert_eq!(dataset["observations"]["achieved_goal"], json!([51, 3]));
}

#[test]
fn lerobot_reads_its_datasets() {
    let Some(python) = python() else { return };
    let rher = recorded("push");
    rher.ok("export out.mcap --format lerobot --out dataset");
    let dataset = parse(&python::run(python, "lerobot_dataset.py", &[&rher.path("dataset")]));
    assert_eq!((&dataset["episodes"], &dataset["frames"]), (&json!(3), &json!(150)));
    assert_eq!((&dataset["fps"], &dataset["task"]), (&json!(25), &json!("push")));
    assert_eq!(
        dataset["shapes"],
        json!({
            "observation.state": [25], "observation.environment_state": [3], "action": [4],
            "next.reward": [], "next.done": [], "next.success": [], "timestamp": [],
            "frame_index": [], "episode_index": [], "index": [], "task_index": [],
        })
    );
    assert_eq!(dataset["batch"], json!([8, 25]));
    assert_eq!(dataset["second"], json!([1, 50, 1]));
    assert_eq!(dataset["window"], json!([3, 4]));
    assert_eq!(dataset["done"], json!([false, false, true]));
    let names = ["count", "max", "mean", "min", "q01", "q10", "q50", "q90", "q99", "std"];
    assert_eq!(dataset["stats"], json!(names));
}

#[test]
fn a_dataset_that_cannot_be_made_leaves_nothing_behind() {
    let rher = recorded("push");
    rher.write("text.mcap", "not a recording");
    std::fs::create_dir(rher.path("taken")).unwrap();
    let files = || std::fs::read_dir(rher.path("")).unwrap().count();
    let before = files();
    for (arguments, status, problem) in [
        ("text.mcap --format minari --out new", 11, "is not an MCAP file"),
        ("nowhere --format minari --out new", 5, "cannot read policy file"),
        ("run --format minari --out taken", 6, "`taken` exists already"),
        ("run --format lerobot --out run/config.toml/new --episodes 1", 6, "cannot write"),
        ("run --format lerobot --out new --episodes 0", 2, "invalid value '0'"),
        ("run --format csv --out new", 2, "invalid value 'csv'"),
    ] {
        let ran = rher.run(&format!("export {arguments}"));
        assert_eq!(ran.status, Some(status), "{arguments}: {ran}");
        assert!(ran.stderr.contains(problem), "{ran}");
        assert_eq!(files(), before, "{arguments}");
    }
}
