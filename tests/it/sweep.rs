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
    error: --set: `relay.mirror` is 2.0, expected a number from 0 to 1

    hint: `rher config <TASK>` prints every setting with its value
    ");
    assert_snapshot!(rher.run("sweep reach --seeds 3-1"), @"
    exit 2
    error: invalid value '3-1' for '--seeds <SEEDS>': expected seeds as in `1-5` or `1,2,7`

    For more information, try '--help'.
    ");
    assert!(!rher.path("grid").exists());
}

/// A sweep of two runs that nobody waits for.
fn endless() -> Rher {
    let rher = Rher::new();
    rher.write(
        "endless.toml",
        "until = 0.0\nenv_steps = 100000000\n[agent]\nhidden = [8]\n\
         [replay]\nbatch_size = 8\nupdates_per_episode = 1\n\
         [evaluation]\nevery_episodes = 5\nepisodes = 2\nsubtask_episodes = 2\n",
    );
    rher
}

const ENDLESS: &str = "sweep reach --seeds 1-2 --jobs 1 --out grid --config endless.toml";

#[test]
fn a_signal_is_passed_on_to_the_runs_and_nothing_more_is_started() {
    for (signal, status) in [("TERM", 143), ("HUP", 129), ("INT", 130)] {
        let rher = endless();
        let running = rher.spawn(ENDLESS);
        rher.wait_for_metrics("grid/seed=1");
        running.send(signal);
        let ran = running.end();
        assert_eq!(ran.status, Some(status), "{ran}");
        assert!(ran.stdout.contains("0 of 2"), "the table is printed: {ran}");
        rher.wait_until_free("grid/seed=1");
        assert!(!rher.path("grid/seed=2").exists(), "{signal}");
        rher.ok("train --quiet --resume grid/seed=1 --env-steps 1");
    }
}

#[test]
fn a_run_ends_with_the_sweep_that_started_it() {
    let rher = endless();
    let running = rher.spawn(ENDLESS);
    rher.wait_for_metrics("grid/seed=1");
    running.kill();
    rher.wait_until_free("grid/seed=1");
}

#[test]
fn a_hangup_that_is_ignored_stays_ignored() {
    let rher = endless();
    let running = rher.spawn_ignoring_hangups(ENDLESS);
    rher.wait_for_metrics("grid/seed=1");
    running.send("HUP");
    std::thread::sleep(std::time::Duration::from_millis(500));
    running.send("TERM");
    let ran = running.end();
    assert_eq!(ran.status, Some(143), "{ran}");
}

#[test]
fn a_sweep_does_not_take_other_runs_for_its_own() {
    let rher = tiny();
    rher.ok(GRID);
    let ran = rher.run(&format!("{GRID} --method her"));
    assert_snapshot!(ran, @r#"
    exit 5
    error: the run in `grid/relay.mirror=0,agent.hidden=[8],seed=1` has `relay.method` = "rher", but "her" is asked for

    hint: choose another folder with --out, or give the settings of the runs that are there
    "#);
    // How far runs go may change.
    rher.ok(&GRID.replace("--env-steps 100", "--env-steps 200"));
    let last = rher.metrics("grid/relay.mirror=0,agent.hidden=[8],seed=1").pop().unwrap();
    assert_eq!(last["env_steps"], 200);
}

#[test]
fn every_run_has_the_settings_that_the_sweep_began_with() {
    let rher = endless();
    let running = rher.spawn(&format!("{ENDLESS} --env-steps 3000"));
    rher.wait_for_metrics("grid/seed=1");
    rher.write("endless.toml", "[agent]\nhidden = [4]\n");
    assert_eq!(running.end().status, Some(0));
    for seed in [1, 2] {
        let config = rher.path(format!("grid/seed={seed}/config.toml"));
        assert!(fs::read_to_string(config).unwrap().contains("hidden = [8]\n"), "seed {seed}");
    }
}

#[test]
fn a_program_that_is_replaced_goes_on_starting_runs() {
    let rher = endless();
    fs::copy(env!("CARGO_BIN_EXE_rher"), rher.path("rher")).unwrap();
    let mut command = std::process::Command::new(rher.path("rher"));
    command
        .current_dir(rher.path(""))
        .args(ENDLESS.split_whitespace())
        .args(["--env-steps", "500"]);
    let mut child = command.stdout(std::process::Stdio::null()).spawn().unwrap();
    rher.wait_for_metrics("grid/seed=1");
    fs::remove_file(rher.path("rher")).unwrap();
    rher.write("rher", "not a program");
    assert!(child.wait().unwrap().success());
    assert!(!rher.metrics("grid/seed=2").is_empty());
}

#[test]
fn what_is_given_twice_is_refused_and_long_names_are_cut() {
    let rher = tiny();
    for sets in ["--set relay.mirror=0.5,0.50", "--set relay.mirror=0 --set relay.mirror=1"] {
        let ran = rher.run(&format!("sweep reach --out grid {sets}"));
        assert_eq!(ran.status, Some(2), "{ran}");
    }
    assert!(!rher.path("grid").exists());
    let long = "--set agent.actor_learning_rate=0.0001 --set agent.critic_learning_rate=0.0001 \
        --set exploration.noise=0.25 --set evaluation.subtask_episodes=2 --set agent.discount=0.95 \
        --set replay.updates_per_episode=1 --set relay.reach_distance=0.03 --set relay.mirror=0.5 \
        --set evaluation.every_episodes=1";
    rher.ok(&format!(
        "sweep reach --out grid --seeds 1-2 --env-steps 50 --config tiny.toml {long}"
    ));
    let names: Vec<_> = fs::read_dir(rher.path("grid")).unwrap().collect();
    assert_eq!(names.len(), 2);
}
