//! A run that a program of its own trains, without the command line.

use rher_core::config::{Preset, TrainConfig};
use rher_core::testing::Carry;
use rher_core::train::{Finish, Trainer};
use rher_runs::{Run, RunDir, RunFiles};
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn config() -> TrainConfig {
    let mut config = Preset::Fast.config("carry", 1);
    config.env_steps = 500;
    config.until = 0.0;
    config.agent.hidden = vec![16, 16];
    config.replay.batch_size = 16;
    config.replay.updates_per_episode = 2;
    config.evaluation.every_episodes = 5;
    config.evaluation.episodes = 5;
    config
}

fn run(mut trainer: Trainer<1, Carry>, folder: RunDir) -> Finish {
    let path = folder.path().to_owned();
    let mut files = RunFiles::new(folder, &trainer).unwrap();
    let finish = trainer.run(Some(&path), &mut files, &AtomicBool::new(false)).unwrap();
    files.close().unwrap();
    finish
}

#[test]
fn the_folder_of_a_run_of_ones_own_is_whole() {
    let place = tempfile::tempdir().unwrap();
    let path: &Path = &place.path().join("mine");
    let trainer = Trainer::new(config(), vec![Carry::new()], 1).unwrap();
    assert_eq!(run(trainer, RunDir::create(path).unwrap()), Finish::StepsSpent);
    let first = Run::read(path).unwrap();
    assert_eq!((first.group.task.as_str(), first.last().env_steps), ("carry", 500));
    for file in ["config.toml", "machine.toml", "metrics.jsonl", "policy.safetensors"] {
        assert!(path.join(file).exists(), "{file}");
    }
    assert!(RunDir::create(path).unwrap_err().to_string().contains("already holds a run"));

    let folder = RunDir::open(path).unwrap();
    let mut trainer = Trainer::resume(path, vec![Carry::new()], 1).unwrap();
    trainer.set_env_steps(1000);
    assert_eq!(run(trainer, folder), Finish::StepsSpent);
    let second = Run::read(path).unwrap();
    assert_eq!((second.id, second.last().env_steps), (first.id, 1000));
    assert_eq!(second.evaluations.len(), 2 * first.evaluations.len());
}
