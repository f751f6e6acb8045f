//! `rher reproduce`: the paper's experiments.

use crate::support::Rher;
use serde_json::Value;

#[test]
fn an_experiment_is_trained_once_and_told_again() {
    let rher = Rher::new();
    let command = "reproduce policies --seeds 1 --env-steps 50 --out out --json";
    let cells: Value = serde_json::from_str(&rher.ok(command)).unwrap();
    let settings: Vec<_> = cells.as_array().unwrap().iter().map(|cell| &cell["settings"]).collect();
    assert_eq!(
        settings,
        [
            "train=mix test=final",
            "train=mix test=guide",
            "train=mix test=mix",
            "train=guide test=final",
            "train=guide test=guide",
            "train=guide test=mix",
        ]
    );
    let folder = rher.path("out/train=guide,test=mix,seed=1");
    let config = std::fs::read_to_string(folder.join("config.toml")).unwrap();
    for line in ["preset = \"paper\"", "train_policy = \"guide\"", "test_policy = \"mix\""] {
        assert!(config.lines().any(|found| found == line), "{line} in {config}");
    }
    let metrics = std::fs::read(folder.join("metrics.jsonl")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&rher.ok(command)).unwrap(), cells);
    assert_eq!(std::fs::read(folder.join("metrics.jsonl")).unwrap(), metrics);
}

#[test]
fn an_unknown_experiment_is_an_error() {
    let ran = Rher::new().run("reproduce figure-9");
    assert_eq!(ran.status, Some(2));
    assert!(ran.stderr.contains("possible values: policies, reach-distance"), "{ran}");
}
