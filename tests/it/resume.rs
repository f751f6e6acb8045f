//! A run that stops, however it stops, goes on as if it had not.

use crate::support::{Rher, Running, TINY};
use insta::assert_snapshot;
use std::fs;
use std::time::{Duration, Instant, SystemTime};

/// Long enough for a kill to fall anywhere.
fn run(out: &str) -> String {
    format!("train push --quiet --env-steps 5000 {TINY} --out {out}")
}

/// A run of a second or more that was stopped after its first evaluation.
fn interrupted(rher: &Rher, out: &str) {
    let running = rher.spawn(&run(out));
    rher.wait_for_metrics(out);
    running.interrupt();
    let ran = running.end();
    assert_eq!(ran.status, Some(130), "{ran}");
}

#[test]
fn killed_at_any_moment_a_run_ends_with_the_same_metrics() {
    let rher = Rher::new();
    rher.ok(&run("straight"));
    let start = || -> Running {
        // Before the first checkpoint there is nothing to resume, and nothing to lose.
        let checkpoints = ["killed/checkpoint/current.ckpt", "killed/checkpoint/previous.ckpt"];
        if checkpoints.iter().any(|file| rher.path(file).exists()) {
            rher.spawn("train --quiet --resume killed")
        } else {
            rher.spawn(&run("killed"))
        }
    };
    let clock = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap();
    let mut random = clock.subsec_nanos();
    for _ in 0..15 {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let delay = Duration::from_micros(u64::from(random >> 16));
        let running = start();
        std::thread::sleep(delay);
        running.kill();
    }
    let ran = start().end();
    assert_eq!(ran.status, Some(0), "{ran}");
    assert_eq!(rher.metrics("killed"), rher.metrics("straight"));
}

#[test]
fn ctrl_c_saves_and_the_run_goes_on() {
    let rher = Rher::new();
    rher.ok(&run("straight"));
    interrupted(&rher, "stopped");
    assert!(rher.metrics("stopped").len() < rher.metrics("straight").len());
    rher.ok("train --quiet --resume stopped");
    assert_eq!(rher.metrics("stopped"), rher.metrics("straight"));
}

#[test]
fn a_stop_within_updates_or_an_evaluation_is_quick_and_changes_nothing() {
    let rher = Rher::new();
    // The updates of an episode take longer than the first signals wait, on a fast machine, too;
    // later ones wait longer, so that a slow one gets to the end.
    let run = "train push --quiet --workers 1 --env-steps 300 --until 0 --set agent.hidden=[32,32] \
        --set replay.batch_size=32 --set replay.updates_per_episode=2500 \
        --set replay.warmup_episodes=0 --set evaluation.every_episodes=1 \
        --set evaluation.episodes=40 --set evaluation.subtask_episodes=10";
    rher.ok(&format!("{run} --out straight"));
    let checkpoint = rher.path("stopped/checkpoint/current.ckpt");
    let mut stops = 0;
    loop {
        let running = rher.spawn(&if checkpoint.exists() {
            "train --quiet --workers 1 --resume stopped".to_owned()
        } else {
            format!("{run} --out stopped")
        });
        std::thread::sleep(Duration::from_millis(30 + 17 * (stops % 5) + 10 * stops));
        let asked = Instant::now();
        running.send(["TERM", "USR1"][stops as usize % 2]);
        let ran = running.end();
        match ran.status {
            Some(0) => break,
            // Where the signal came before the program listened to it.
            None => {}
            Some(143) => stops += 1,
            _ => panic!("{ran}"),
        }
        assert!(asked.elapsed() < Duration::from_secs(5), "{:?}", asked.elapsed());
        assert!(stops < 100, "the run does not get on");
    }
    assert!(stops > 3, "only {stops} stops");
    assert_eq!(rher.metrics("stopped"), rher.metrics("straight"));
    let policy = |run: &str| fs::read(rher.path(run).join("policy.safetensors")).unwrap();
    assert_eq!(policy("stopped"), policy("straight"));
}

#[test]
fn metrics_after_the_checkpoint_are_cut_off() {
    let rher = Rher::new();
    rher.ok(&run("straight"));
    interrupted(&rher, "stopped");
    let path = rher.path("stopped/metrics.jsonl");
    let mut text = fs::read_to_string(&path).unwrap();
    text.push_str("{\"env_steps\": 1}\n{\"half a li");
    fs::write(&path, text).unwrap();
    rher.ok("train --quiet --resume stopped");
    assert_eq!(rher.metrics("stopped"), rher.metrics("straight"));
}

#[test]
fn lost_metrics_are_told() {
    let rher = Rher::new();
    rher.ok(&format!("train push --quiet --env-steps 500 {TINY} --out run"));
    rher.write("run/metrics.jsonl", "");
    assert_snapshot!(rher.run("train --resume run --env-steps 1000"), @"
    exit 8
    error: `run/metrics.jsonl` has 0 complete lines, but the checkpoint was made after 2 evaluations

    hint: restore the file, or start a new run with --out
    ");
}

#[test]
fn a_finished_run_says_so_and_can_be_taken_further() {
    let rher = Rher::new();
    rher.ok(&format!("train push --quiet --env-steps 500 {TINY} --out run"));
    assert_snapshot!(rher.run("train --resume run"), @"
    exit 0
    `run` is finished: it took all of its steps, after 500 steps

    hint: `rher train --resume run --env-steps N` with more steps continues it
    ");
    assert_eq!(rher.ok("train --quiet --resume run --env-steps 1000"), "");
    let steps: Vec<_> = rher.metrics("run").iter().map(|line| line["env_steps"].clone()).collect();
    assert_eq!(steps, [250, 500, 750, 1000]);
    let config = fs::read_to_string(rher.path("run/config.toml")).unwrap();
    assert!(config.contains("env_steps = 1000\n"), "{config}");
}

#[test]
fn a_solved_run_goes_on_to_more_steps_when_it_is_asked_to() {
    let rher = Rher::new();
    // Some of the blocks are where they should go.
    let few = TINY.replace("--until 0 ", "--until 0.01 ");
    let few = few.replace("evaluation.episodes=5", "evaluation.episodes=60");
    rher.ok(&format!("train push --quiet --env-steps 5000 {few} --out run"));
    let steps = rher.metrics("run").last().unwrap()["env_steps"].as_u64().unwrap();
    assert!(steps < 5000, "{steps}");
    let says = rher.run(&format!("train --resume run --env-steps {steps}")).stderr;
    assert!(says.contains("is finished: it reached its success rate"), "{says}");
    let more = steps + 500;
    let says = rher.run(&format!("train --resume run --env-steps {more}")).stderr;
    assert!(says.contains("all steps taken after"), "{says}");
    assert_eq!(rher.metrics("run").last().unwrap()["env_steps"], more);
}

#[test]
fn a_folder_belongs_to_one_process_and_its_lock_dies_with_it() {
    let rher = Rher::new();
    let running = rher.spawn(&format!("train push --quiet --env-steps 100000000 {TINY} --out run"));
    rher.wait_for_metrics("run");
    assert_snapshot!(rher.run("train push --out run"), @"
    exit 5
    error: `run` is in use by another process

    hint: wait until that process ends, or choose another folder with --out
    ");
    assert_snapshot!(rher.run("train --resume run"), @"
    exit 5
    error: `run` is in use by another process

    hint: wait until that process ends, or choose another folder with --out
    ");
    running.kill();
    assert_snapshot!(rher.run("train push --out run"), @"
    exit 5
    error: `run` already holds a run

    hint: `rher train --resume run` continues it; `--out DIR` starts a run elsewhere
    ");
    rher.ok("train --quiet --resume run --env-steps 500");
}

#[test]
fn a_truncated_checkpoint_is_named_with_the_last_good_one() {
    let rher = Rher::new();
    rher.ok(&format!("train push --quiet --env-steps 500 {TINY} --out run"));
    let path = rher.path("run/checkpoint/current.ckpt");
    let good = fs::read(&path).unwrap();
    fs::write(&path, &good[..100]).unwrap();
    let state = (good.len() - 24).to_string();
    let ran = rher.run("train --resume run").to_string().replace(&state, "[all of it]");
    assert_snapshot!(ran, @"
    exit 8
    error: `run/checkpoint/current.ckpt` is damaged: 76 bytes of state, expected [all of it]; the last good one is `run/checkpoint/previous.ckpt`, at environment step 250

    hint: nothing was changed; to resume from an earlier checkpoint, rename it to `current.ckpt`; the policy file still works
    ");
    fs::write(&path, b"").unwrap();
    assert_snapshot!(rher.run("train --resume run"), @"
    exit 8
    error: `run/checkpoint/current.ckpt` is damaged: 0 bytes, shorter than its header; the last good one is `run/checkpoint/previous.ckpt`, at environment step 250

    hint: nothing was changed; to resume from an earlier checkpoint, rename it to `current.ckpt`; the policy file still works
    ");
    let straight = rher.metrics("run");
    fs::rename(rher.path("run/checkpoint/previous.ckpt"), &path).unwrap();
    rher.ok("train --quiet --resume run");
    assert_eq!(rher.metrics("run"), straight);
}

#[test]
fn a_damaged_checkpoint_is_named() {
    let rher = Rher::new();
    rher.ok(&format!("train push --quiet --env-steps 500 {TINY} --out run"));
    let flip = |name: &str| {
        let path = rher.path(name);
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes).unwrap();
    };
    flip("run/checkpoint/replay-000000.episodes");
    let ran = rher.run("train --resume run --env-steps 1000");
    assert_eq!(ran.status, Some(8), "{ran}");
    assert!(ran.stderr.contains("`run/checkpoint/replay-000000.episodes` is damaged"), "{ran}");
    flip("run/checkpoint/current.ckpt");
    let ran = rher.run("train --resume run --env-steps 1000");
    assert_eq!(ran.status, Some(8), "{ran}");
    assert!(ran.stderr.contains("`run/checkpoint/current.ckpt` is damaged"), "{ran}");
    assert!(ran.stderr.contains("the last good one is `run/checkpoint/previous.ckpt`"), "{ran}");
}

#[test]
fn only_what_is_no_part_of_the_experiment_may_change() {
    let rher = Rher::new();
    assert_snapshot!(rher.run("train --resume run --seed 2"), @"
    exit 2
    error: the argument '--resume <DIR>' cannot be used with '--seed <N>'

    Usage: rher train --resume <DIR> [TASK]

    For more information, try '--help'.
    ");
    assert_snapshot!(rher.run("train push --resume run"), @"
    exit 2
    error: the argument '[TASK]' cannot be used with '--resume <DIR>'

    Usage: rher train <TASK>

    For more information, try '--help'.
    ");
    assert_snapshot!(rher.run("train --resume run"), @"
    exit 5
    error: `run` holds no run

    hint: `rher train <TASK> --out DIR` starts a run
    ");
}
