//! A folder is one run: what is of another, damaged, moved or there twice is noticed.

use crate::support::{Rher, TINY};
use insta::assert_snapshot;
use std::fs;

/// A run of `reach` with a seed, in a folder of this name.
fn train(rher: &Rher, name: &str, seed: u32) {
    rher.ok(&format!("train reach --quiet --seed {seed} --env-steps 300 {TINY} --out {name}"));
}

#[test]
fn equal_runs_have_equal_files() {
    let rher = Rher::new();
    train(&rher, "a", 1);
    train(&rher, "b", 1);
    for file in ["config.toml", "policy.safetensors"] {
        let read = |run: &str| fs::read(rher.path(run).join(file)).unwrap();
        assert!(read("a") == read("b"), "{file}");
    }
    let id = |run| fs::read_to_string(rher.path(run).join("config.toml")).unwrap()[..38].to_owned();
    train(&rher, "c", 2);
    assert_ne!(id("a"), id("c"));
}

#[test]
fn files_of_another_run_are_noticed() {
    let rher = Rher::new();
    train(&rher, "a", 1);
    train(&rher, "b", 2);
    let copy = |file: &str| fs::copy(rher.path("b").join(file), rher.path("a").join(file)).unwrap();
    copy("policy.safetensors");
    for verb in ["eval a --episodes 2", "play a --mcap a.mcap --episodes 1"] {
        let ran = rher.run(verb);
        assert_eq!(ran.status, Some(8), "{}", ran.stderr);
        assert!(ran.stderr.contains("holds files of two runs"), "{}", ran.stderr);
    }
    // The checkpoint, the policy and the settings of the other run, and the metrics of this one.
    copy("config.toml");
    copy("checkpoint/current.ckpt");
    copy("checkpoint/replay-000000.episodes");
    for verb in ["train --resume a --env-steps 600", "stats a", "plot a -o a.svg"] {
        let ran = rher.run(verb);
        assert_eq!(ran.status, Some(8), "{}", ran.stderr);
        assert!(ran.stderr.contains("but the folder is that of run"), "{}", ran.stderr);
    }
}

#[test]
fn settings_that_were_changed_are_not_used_silently() {
    let rher = Rher::new();
    train(&rher, "a", 1);
    let file = rher.path("a").join("config.toml");
    let settings = fs::read_to_string(&file).unwrap();
    fs::write(&file, settings.replace("test_policy = \"final\"", "test_policy = \"staged\""))
        .unwrap();
    for verb in ["eval a --episodes 2", "stats a", "report a -o a.html"] {
        let ran = rher.run(verb);
        assert_eq!(ran.status, Some(8), "{verb}: {}", ran.stderr);
        assert!(ran.stderr.contains("was changed after it was written"), "{}", ran.stderr);
    }
    // Without the file, the settings in the checkpoint count.
    fs::remove_file(&file).unwrap();
    rher.ok("eval a --episodes 2");
}

#[test]
fn a_finished_run_whose_policy_is_old_or_missing_gets_it_again() {
    let rher = Rher::new();
    train(&rher, "a", 1);
    let file = rher.path("a").join("policy.safetensors");
    let policy = fs::read(&file).unwrap();
    let damaged: [&dyn Fn(); 3] = [
        &|| fs::remove_file(&file).unwrap(),
        &|| fs::write(&file, &policy[..policy.len() / 2]).unwrap(),
        &|| {
            train(&rher, "shorter", 1);
            rher.ok("train --resume shorter --env-steps 400 --quiet");
            fs::copy(rher.path("shorter/policy.safetensors"), &file).unwrap();
        },
    ];
    for damage in damaged {
        damage();
        rher.ok("train --resume a --quiet");
        assert!(fs::read(&file).unwrap() == policy);
    }
}

#[test]
fn a_run_whose_folder_is_moved_stops_and_can_be_resumed_there() {
    let rher = Rher::new();
    let run = format!("train reach --quiet --env-steps 100000000 {TINY} --out a");
    let running = rher.spawn(&run);
    rher.wait_for_metrics("a");
    fs::rename(rher.path("a"), rher.path("b")).unwrap();
    let ran = running.end();
    assert_eq!(ran.status, Some(14), "{}", ran.stderr);
    assert_snapshot!(ran.stderr, @"
    error: the run folder `a` was moved, deleted or replaced during the run

    hint: what was saved before is where the folder is now; there, `rher train --resume DIR` continues the run
    ");
    assert!(!rher.path("a").exists(), "the folder was made again");
    rher.ok("train --resume b --env-steps 1 --quiet");
    rher.ok("eval b --episodes 2");
}

#[test]
fn a_run_whose_folder_is_replaced_writes_nothing_there() {
    let rher = Rher::new();
    let run = format!("train reach --quiet --env-steps 100000000 {TINY} --out a");
    let running = rher.spawn(&run);
    rher.wait_for_metrics("a");
    fs::rename(rher.path("a"), rher.path("b")).unwrap();
    train(&rher, "a", 2);
    let policy = fs::read(rher.path("a/policy.safetensors")).unwrap();
    let ran = running.end();
    assert_eq!(ran.status, Some(14), "{}", ran.stderr);
    assert!(fs::read(rher.path("a/policy.safetensors")).unwrap() == policy);
    rher.ok("train --resume a --quiet");
}

#[test]
fn a_run_counts_once() {
    let rher = Rher::new();
    train(&rher, "a", 1);
    train(&rher, "b", 2);
    train(&rher, "same", 1);
    let twice = rher.run("stats a b b ./b same --json");
    assert_eq!(twice.stdout, rher.ok("stats a b --json"));
    assert_eq!(twice.stderr.matches("is left out").count(), 3, "{}", twice.stderr);
}
