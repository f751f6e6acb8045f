//! A grid of runs.

use crate::support::Rher;
use insta::assert_snapshot;
use serde_json::Value;
use std::fs;

const GRID: &str = "sweep reach --until 0 --env-steps 100 --seeds 1-2 --jobs 2 --out grid \
    --config tiny.toml --set relay.mirror=0,0.5 --set agent.hidden=[8]";

fn tiny() -> Rher {
    let rher = Rher::new();
    rher.write(
        "tiny.toml",
        "[replay]\nbatch_size = 8\nupdates_per_episode = 1\n\
         [evaluation]\nevery_episodes = 1\nepisodes = 2\nsubtask_episodes = 2\n",
    );
    rher
}

#[test]
fn every_combination_is_a_run_and_finished_ones_are_left_alone() {
    let rher = tiny();
    let cells: Value = serde_json::from_str(&rher.ok(&format!("{GRID} --json"))).unwrap();
    assert_eq!(cells[0]["settings"], "relay.mirror=0 agent.hidden=[8]");
    assert_eq!((&cells[1]["runs"], &cells[1]["solved"]), (&2.into(), &0.into()));
    let metrics =
        |name: &str| fs::read(rher.path("grid").join(name).join("metrics.jsonl")).unwrap();
    let names: Vec<_> = ["0", "0.5"]
        .iter()
        .flat_map(|mirror| {
            ["1", "2"].map(|seed| format!("relay.mirror={mirror},agent.hidden=[8],seed={seed}"))
        })
        .collect();
    let before: Vec<_> = names.iter().map(|name| metrics(name)).collect();
    assert_ne!(before[0], before[2]);

    fs::remove_dir_all(rher.path("grid").join(&names[1])).unwrap();
    rher.ok(GRID);
    assert!(!metrics(&names[1]).is_empty());
    for (name, before) in names.iter().zip(before).filter(|(name, _)| **name != names[1]) {
        assert_eq!(metrics(name), before);
    }
}

#[test]
fn a_wrong_grid_starts_nothing() {
    let rher = Rher::new();
    assert_snapshot!(rher.run("sweep reach --set relay.mirror=0,2 --out grid"), @"
    exit 2
    error: --set: `relay.mirror` is 2, expected 0 to 1

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(rher.run("sweep reach --seeds 3-1"), @"
    exit 2
    error: invalid value '3-1' for '--seeds <SEEDS>': expected seeds as in `1-5` or `1,2,7`

    For more information, try '--help'.
    ");
    assert!(!rher.path("grid").exists());
}
