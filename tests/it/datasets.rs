//! Datasets, judged by the readers of the packages whose format they have.

use crate::python::{self, python, python_3_12};
use crate::support::{Rher, TINY};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

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
    assert_eq!(dataset["successes"], json!([71, 1]));
    assert_eq!(dataset["truncated_at"], json!([69, 69, 69]));
    assert_eq!((&dataset["terminated"], &dataset["sampled"]), (&json!(false), &json!(2)));
    // As in the Gymnasium environments.
    assert_eq!(dataset["kinds"], json!({ "observations": "float64", "actions": "float32" }));
    assert_eq!(
        dataset["limits"],
        json!({ "observations": [-100.0, 100.0], "actions": [-1.0, 1.0] })
    );
}

/// Runs Minari's command line on the datasets below `root`.
fn minari(python: &Path, root: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(python.with_file_name("minari"));
    command.args(arguments).env("MINARI_DATASETS_PATH", root).env("COLUMNS", "200");
    let output = command.output().unwrap();
    let [stdout, stderr] =
        [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(output.status.success(), "minari {arguments:?}: {stdout}{stderr}");
    stdout
}

#[test]
fn minari_lists_shows_and_combines_datasets_of_one_task() {
    let Some(python) = python() else { return };
    let rher = recorded("push");
    let root = rher.path("root");
    rher.ok("export run --format minari --out root/rher/push-v0 --episodes 2");
    rher.ok("export run --format minari --out root/rher/push-v1 --episodes 3 --seed 7 \
             --dataset-id rher/push-v1");
    let list = minari(python, &root, &["list", "local", "--all"]);
    // Minari shows the latest version of a name.
    assert!(list.contains("rher/push-v1") && list.contains(" MB"), "{list}");
    for id in ["rher/push-v0", "rher/push-v1"] {
        let shown = minari(python, &root, &["show", id]);
        assert!(shown.contains("Environment Specs") && shown.contains("rher/Push-v0"), "{shown}");
        assert!(shown.contains("Evaluation Environment Specs"), "{shown}");
    }
    let ids = ["combine", "rher/push-v0", "rher/push-v1", "--dataset-id", "rher/both-v0"];
    minari(python, &root, &ids);
    let read = |name: &str| {
        parse(&python::run(python, "minari_dataset.py", &[&root.join(name).join("data")]))
    };
    let [both, second] = ["rher/both-v0", "rher/push-v1"].map(read);
    assert_eq!((&both["total_episodes"], &both["total_steps"]), (&json!(5), &json!(250)));
    // The size in megabytes is as Minari counts it.
    assert_eq!(second["size"][0], second["size"][1], "{second}");
}

#[test]
fn a_dataset_has_an_identity_that_minari_accepts() {
    let rher = recorded("push");
    for (arguments, problem) in [
        ("--format minari --dataset-id push", "such as rher/push-v1"),
        ("--format lerobot --dataset-id rher/push-v1", "is for `--format minari`"),
    ] {
        let ran = rher.run(&format!("export run --out new {arguments}"));
        assert_eq!(ran.status, Some(2), "{ran}");
        assert!(ran.stderr.contains(problem), "{ran}");
        assert!(!rher.path("new").exists());
    }
}

#[test]
fn two_exports_to_one_folder_do_not_disturb_each_other() {
    let rher = recorded("push");
    let export = "export run --format minari --out dataset --episodes 60";
    let both = [rher.spawn(export), rher.spawn(export)].map(crate::support::Running::end);
    let mut ended: Vec<_> = both.iter().map(|ran| ran.status).collect();
    ended.sort_unstable();
    assert_eq!(ended, [Some(0), Some(6)], "{} {}", both[0], both[1]);
    let entries = || std::fs::read_dir(rher.path("")).unwrap().map(|entry| entry.unwrap().path());
    let left: Vec<_> = entries().filter(|path| path.to_string_lossy().contains("part")).collect();
    assert_eq!(left, Vec::<std::path::PathBuf>::new());
    assert_eq!(std::fs::read_dir(rher.path("dataset/data")).unwrap().count(), 61);

    // What a killed export leaves behind is gone after the next one.
    std::fs::create_dir_all(rher.path("other.part/data/0")).unwrap();
    rher.ok("export run --format lerobot --out other --episodes 1");
    assert!(!rher.path("other.part").exists());
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
fn lerobot_0_4_reads_its_datasets() {
    let Some(python) = python() else { return };
    lerobot_reads_a_dataset(python);
}

#[test]
fn lerobot_0_6_reads_its_datasets() {
    let Some(python) = python_3_12() else { return };
    lerobot_reads_a_dataset(&python);
}

fn lerobot_reads_a_dataset(python: &Path) {
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
    assert_eq!(dataset["batch"], json!({ "observation.state": [8, 25], "next.reward": [8] }));
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
        ("nowhere --format minari --out new", 5, "cannot read `nowhere`"),
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
