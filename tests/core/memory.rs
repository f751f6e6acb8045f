//! The estimate of the memory that a run needs is near what it takes.

use crate::toy::{Lines, Magnet, small};
use rher_core::config::TrainConfig;
use rher_core::env::Env as _;
use rher_core::train::{TrainError, Trainer, memory};
use std::process::Command;
use std::sync::atomic::AtomicBool;

/// Settings of which one kind needs nearly all of the memory.
const KINDS: [&str; 3] = ["replay", "networks", "rows"];

fn config(kind: &str) -> TrainConfig {
    let mut config = small("magnet", 2);
    config.until = 0.0;
    config.replay.updates_per_episode = 1;
    config.replay.capacity = 1_000;
    config.evaluation.every_episodes = 100_000;
    config.agent.hidden = vec![16];
    match kind {
        "replay" => {
            config.replay.capacity = 1_000_000;
            config.env_steps = 1_000_000;
            config.replay.warmup_episodes = 1_000_000;
        }
        "networks" => {
            config.agent.hidden = vec![1024, 1024];
            config.env_steps = 50;
        }
        _ => {
            config.replay.batch_size = 200_000;
            config.env_steps = 50;
        }
    }
    config
}

/// The most memory that this process ever had, in bytes.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    1024 * line.trim().strip_suffix(" kB").unwrap().parse::<u64>().unwrap()
}

/// Runs in a process of its own, whose memory is that of one run.
#[test]
#[ignore = "the other test runs it"]
#[expect(clippy::print_stdout, reason = "the other test reads it")]
fn one_run() {
    let config = config(&std::env::var("KIND").unwrap());
    let before = peak();
    let folder = tempfile::tempdir().unwrap();
    let mut trainer = Trainer::new(config, vec![Magnet::<2>::new()], 1).unwrap();
    trainer.run(Some(folder.path()), &mut Lines::default(), &AtomicBool::new(false)).unwrap();
    println!("took {}", peak() - before);
}

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "reads /proc")]
fn the_estimate_is_near_the_truth() {
    for kind in KINDS {
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["memory::one_run", "--exact", "--ignored", "--nocapture"])
            .env("KIND", kind)
            .output()
            .unwrap();
        let output = String::from_utf8(child.stdout).unwrap();
        let took = output.lines().find_map(|line| line.split_once("took ")).unwrap_or_else(|| {
            panic!("{kind}: {output}{}", String::from_utf8_lossy(&child.stderr))
        });
        let took: u64 = took.1.parse().unwrap();
        let needed = memory::needed(&config(kind), Magnet::<2>::new().spec());
        let ratio = needed.total() as f64 / took as f64;
        assert!((0.8..1.6).contains(&ratio), "{kind}: {needed:?}, took {took}");
    }
}

#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "the memory of this machine is not known")]
fn what_does_not_fit_is_refused_before_it_is_made() {
    let huge = [
        |config: &mut TrainConfig| config.replay.capacity = 1_000_000_000_000,
        |config: &mut TrainConfig| config.replay.capacity = usize::MAX / 2,
        |config: &mut TrainConfig| config.replay.batch_size = usize::MAX / 2,
        |config: &mut TrainConfig| config.agent.hidden = vec![65_536; 64],
    ];
    for change in huge {
        let mut config = small("magnet", 2);
        change(&mut config);
        let error = Trainer::new(config, vec![Magnet::<2>::new()], 1).err().unwrap();
        assert!(matches!(error, TrainError::Memory(_)), "{error}");
        assert!(error.to_string().contains("and there are"), "{error}");
    }
}
