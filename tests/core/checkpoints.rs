//! A run that is stopped and resumed is the run that was never stopped.

use crate::toy::{Lines, Magnet, small};
use rher_core::config::{BatchMode, TrainConfig};
use rher_core::event::{Event, Metrics, Observer, ObserverError, Seconds};
use rher_core::train::checkpoint::CheckpointError;
use rher_core::train::{Finish, TrainError, Trainer};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

fn config() -> TrainConfig {
    let mut config = small("magnet", 2);
    config.agent.hidden = vec![8, 8];
    config.agent.critics = 2;
    config.agent.target_noise = 0.2;
    config.agent.policy_delay = 2;
    config.replay.batch_size = 8;
    config.replay.batch_mode = BatchMode::Separate;
    config.replay.updates_per_episode = 3;
    // Few enough that episodes are overwritten within the run.
    config.replay.capacity = 25 * 25;
    config.exploration.adjust_to_success = true;
    config.exploration.success_threshold = 0.05;
    config.evaluation.episodes = 4;
    config.evaluation.subtask_episodes = 3;
    config.env_steps = 60 * 25;
    config
}

fn envs(count: usize) -> Vec<Magnet<2>> {
    (0..count).map(|_| Magnet::new()).collect()
}

/// The lines without what the wall clock says.
fn timeless(lines: &Lines) -> Vec<Metrics> {
    let timeless =
        |metrics: &Metrics| Metrics { wall_s: 0.0, time: Seconds::default(), ..metrics.clone() };
    lines.0.iter().map(timeless).collect()
}

fn straight(config: TrainConfig, workers: usize) -> (Vec<Metrics>, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let mut lines = Lines::default();
    let envs = envs(workers.max(config.envs));
    let mut trainer = Trainer::new(config, envs, workers).unwrap();
    let finish = trainer.run(Some(folder.path()), &mut lines, &AtomicBool::new(false)).unwrap();
    assert_eq!(finish, Finish::StepsSpent);
    (timeless(&lines), fs::read(folder.path().join("policy.safetensors")).unwrap())
}

/// Sets the flag after some episodes.
struct StopAfter<'a> {
    episodes: u64,
    stop: &'a AtomicBool,
    lines: Lines,
}

impl Observer for StopAfter<'_> {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        if let Event::Progress(progress) = event
            && progress.episodes >= self.episodes
        {
            self.stop.store(true, Ordering::Relaxed);
        }
        self.lines.on(event)
    }
}

fn run_until(folder: &Path, trainer: &mut Trainer<2, Magnet<2>>, episodes: u64) -> Lines {
    let stop = AtomicBool::new(false);
    let mut observer = StopAfter { episodes, stop: &stop, lines: Lines::default() };
    let finish = trainer.run(Some(folder), &mut observer, &stop).unwrap();
    assert_eq!(finish, Finish::Stopped);
    observer.lines
}

#[test]
fn stopping_and_resuming_changes_nothing() {
    let (expected, policy) = straight(config(), 1);
    let folder = tempfile::tempdir().unwrap();
    let mut lines = Vec::new();
    let mut trainer = Trainer::new(config(), envs(1), 1).unwrap();
    for episodes in [3, 10, 37, 38] {
        lines.extend(timeless(&run_until(folder.path(), &mut trainer, episodes)));
        trainer = Trainer::resume(folder.path(), envs(1), 1).unwrap();
        assert_eq!(trainer.evaluations(), lines.len() as u64);
    }
    let mut rest = Lines::default();
    trainer.run(Some(folder.path()), &mut rest, &AtomicBool::new(false)).unwrap();
    lines.extend(timeless(&rest));
    assert_eq!(lines, expected);
    assert_eq!(fs::read(folder.path().join("policy.safetensors")).unwrap(), policy);
}

#[test]
fn stopped_at_any_moment_a_run_ends_with_the_same_bits() {
    let mut config = config();
    // Most of the time is that of updates, so that most stops fall there.
    config.agent.hidden = vec![64, 64];
    config.replay.updates_per_episode = 40;
    config.evaluation.episodes = 40;
    let started = Instant::now();
    let expected = straight(config.clone(), 1);
    let mut trainer = Trainer::new(config, envs(1), 1).unwrap();
    let episodes = trainer.config().env_steps as u32 / trainer.spec().episode_steps as u32;
    let an_episode = started.elapsed() / episodes;
    let folder = tempfile::tempdir().unwrap();
    let mut lines = Lines::default();
    let (mut stops, mut within_updates) = (0_u64, 0);
    loop {
        let stop = AtomicBool::new(false);
        let finish = std::thread::scope(|scope| {
            scope.spawn(|| {
                // As long as up to two episodes and their updates, in steps that have no pattern.
                std::thread::sleep(an_episode * (stops * 7919 % 101) as u32 * 2 / 101);
                stop.store(true, Ordering::Relaxed);
            });
            trainer.run(Some(folder.path()), &mut lines, &stop).unwrap()
        });
        if finish == Finish::StepsSpent {
            break;
        }
        stops += 1;
        // Four sub-tasks have a batch each.
        within_updates += u64::from(!trainer.progress().updates.is_multiple_of(4 * 40));
        if stops.is_multiple_of(3) {
            trainer = Trainer::resume(folder.path(), envs(1), 1).unwrap();
        }
    }
    assert!(stops > 20 && within_updates > 5, "{stops} stops, {within_updates} within updates");
    let policy = fs::read(folder.path().join("policy.safetensors")).unwrap();
    assert_eq!((timeless(&lines), policy), expected);
}

#[test]
fn a_run_that_died_goes_on_from_its_last_evaluation() {
    let (expected, _) = straight(config(), 1);
    let folder = tempfile::tempdir().unwrap();
    let mut trainer = Trainer::new(config(), envs(1), 1).unwrap();
    run_until(folder.path(), &mut trainer, 25);
    // What a kill leaves: the state before this one, and records that no state counts.
    let checkpoint = folder.path().join("checkpoint");
    fs::rename(checkpoint.join("previous.ckpt"), checkpoint.join("current.ckpt")).unwrap();
    let mut trainer = Trainer::resume(folder.path(), envs(1), 1).unwrap();
    assert_eq!(trainer.evaluations(), 2);
    let mut lines = Lines::default();
    trainer.run(Some(folder.path()), &mut lines, &AtomicBool::new(false)).unwrap();
    assert_eq!(timeless(&lines), expected[2..]);
}

#[test]
fn a_stop_between_two_renames_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut trainer = Trainer::new(config(), envs(1), 1).unwrap();
    run_until(folder.path(), &mut trainer, 25);
    let checkpoint = folder.path().join("checkpoint");
    fs::rename(checkpoint.join("current.ckpt"), checkpoint.join("next.ckpt")).unwrap();
    let trainer = Trainer::resume(folder.path(), envs(1), 1).unwrap();
    assert_eq!(trainer.progress().episodes, 20);
}

#[cfg(all(feature = "burn", feature = "fused"))]
#[test]
fn a_run_of_one_engine_goes_on_with_the_other() {
    use rher_core::config::EngineKind::{Burn, Fused};
    use rher_core::config::Precision;
    for (first, second) in [(Fused, Burn), (Burn, Fused)] {
        let folder = tempfile::tempdir().unwrap();
        let mut config = config();
        config.agent.engine = first;
        config.agent.precision = Precision::F32;
        let mut trainer = Trainer::new(config, envs(1), 1).unwrap();
        run_until(folder.path(), &mut trainer, 15);
        let before = trainer.policy().clone();
        let mut trainer =
            Trainer::resume_on(Some(second), None, folder.path(), envs(1), 1).unwrap();
        assert_eq!(trainer.policy(), &before);
        run_until(folder.path(), &mut trainer, 30);
        assert_ne!(trainer.policy(), &before);
        let resumed = Trainer::resume(folder.path(), envs(1), 1).unwrap();
        assert_eq!(resumed.config().agent.engine, second);
        assert_eq!(resumed.policy(), trainer.policy());
    }
}

#[cfg(feature = "fused")]
#[test]
fn a_run_of_one_precision_goes_on_with_the_other_when_that_is_asked() {
    use rher_core::config::Precision::{Bf16, F32};
    for (first, second) in [(F32, Bf16), (Bf16, F32)] {
        let folder = tempfile::tempdir().unwrap();
        let mut config = config();
        config.agent.precision = first;
        let mut trainer = Trainer::new(config, envs(1), 1).unwrap();
        run_until(folder.path(), &mut trainer, 15);
        let before = trainer.policy().clone();
        let unasked = Trainer::resume(folder.path(), envs(1), 1).unwrap();
        assert_eq!(unasked.config().agent.precision, first);
        let mut trainer =
            Trainer::resume_on(None, Some(second), folder.path(), envs(1), 1).unwrap();
        assert_eq!(trainer.policy(), &before);
        run_until(folder.path(), &mut trainer, 30);
        let resumed = Trainer::resume(folder.path(), envs(1), 1).unwrap();
        assert_eq!(resumed.config().agent.precision, second);
        assert_eq!(resumed.policy(), trainer.policy());
    }
}

#[cfg(all(feature = "burn", feature = "fused"))]
#[test]
fn a_run_cannot_go_on_with_a_precision_that_its_engine_lacks() {
    use rher_core::config::{EngineKind, Precision};
    let folder = tempfile::tempdir().unwrap();
    let mut config = config();
    config.agent.precision = Precision::Bf16;
    let mut trainer = Trainer::new(config, envs(1), 1).unwrap();
    run_until(folder.path(), &mut trainer, 15);
    let resumed = Trainer::resume_on(Some(EngineKind::Burn), None, folder.path(), envs(1), 1);
    let error = resumed.err().unwrap().to_string();
    assert!(error.contains("`agent.precision` is bf16, expected `f32`"), "{error}");
}

#[cfg(not(all(feature = "burn", feature = "fused")))]
#[test]
fn an_engine_that_is_not_compiled_in_is_refused_by_name() {
    use rher_core::config::EngineKind::{Burn, Fused};
    use rher_core::config::Precision;
    let mut config = config();
    config.agent.precision = Precision::F32;
    config.agent.engine = if cfg!(feature = "fused") { Burn } else { Fused };
    let feature = format!("build with the feature `{}`", config.agent.engine.name());
    let error = Trainer::new(config, envs(1), 1).err().unwrap().to_string();
    assert!(error.contains(&feature), "{error}");
}

#[test]
fn workers_change_nothing() {
    let mut config = config();
    config.envs = 3;
    config.evaluation.every_episodes = 9;
    assert_eq!(straight(config.clone(), 1), straight(config, 2));
}

#[test]
fn seeds_change_everything() {
    let other = TrainConfig { seed: 2, ..config() };
    assert_ne!(straight(config(), 1).0, straight(other, 1).0);
}

#[test]
fn a_damaged_checkpoint_is_named_with_the_last_good_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut trainer = Trainer::new(config(), envs(1), 1).unwrap();
    run_until(folder.path(), &mut trainer, 25);
    let path = folder.path().join("checkpoint/current.ckpt");
    let whole = fs::read(&path).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    for damage in [&flipped[..], &whole[..whole.len() - 1], &whole[..10], &[]] {
        fs::write(&path, damage).unwrap();
        let Err(TrainError::Checkpoint(error)) = Trainer::resume(folder.path(), envs(1), 1) else {
            panic!("{} bytes were accepted", damage.len());
        };
        let CheckpointError::Damaged { path: named, last_good, .. } = &error else {
            panic!("{error}");
        };
        assert_eq!(*named, path);
        assert!(last_good.contains("previous.ckpt"), "{last_good}");
        assert!(last_good.contains("step 500"), "{last_good}");
    }
}

#[test]
fn a_damaged_episode_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut trainer = Trainer::new(config(), envs(1), 1).unwrap();
    run_until(folder.path(), &mut trainer, 12);
    let path = folder.path().join("checkpoint/replay-000000.episodes");
    let mut bytes = fs::read(&path).unwrap();
    let record = bytes.len() / 12;
    bytes[5 * record + 100] ^= 1;
    fs::write(&path, bytes).unwrap();
    let error = Trainer::resume(folder.path(), envs(1), 1).err().unwrap().to_string();
    assert!(error.contains("episode 5: checksum"), "{error}");
}

#[test]
fn a_flipped_bit_of_any_byte_of_a_checkpoint_is_noticed() {
    let mut config = config();
    config.agent.hidden = vec![1];
    let folder = tempfile::tempdir().unwrap();
    let mut trainer = Trainer::new(config, envs(1), 1).unwrap();
    run_until(folder.path(), &mut trainer, 2);
    fs::remove_file(folder.path().join("checkpoint/previous.ckpt")).unwrap();
    for file in ["current.ckpt", "replay-000000.episodes"] {
        let path = folder.path().join("checkpoint").join(file);
        let whole = fs::read(&path).unwrap();
        // One bit of every byte of the checkpoint, and of some of the much longer episodes.
        let every = if file == "current.ckpt" { 1 } else { 37 };
        let flips = (0..whole.len()).map(|byte| 8 * byte + byte % 8).step_by(every);
        for bit in flips {
            let mut damaged = whole.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, damaged).unwrap();
            let resumed = Trainer::resume(folder.path(), envs(1), 1);
            assert!(resumed.is_err(), "bit {bit} of {file}");
        }
        fs::write(&path, whole).unwrap();
    }
    assert!(Trainer::resume(folder.path(), envs(1), 1).is_ok());
}

#[test]
fn episodes_of_another_run_are_refused() {
    let folders = [1, 2].map(|seed| {
        let folder = tempfile::tempdir().unwrap();
        let config = TrainConfig { seed, ..config() };
        let mut trainer = Trainer::new(config, envs(1), 1).unwrap();
        run_until(folder.path(), &mut trainer, 12);
        folder
    });
    let [one, other] =
        folders.each_ref().map(|folder| folder.path().join("checkpoint/replay-000000.episodes"));
    fs::copy(other, one).unwrap();
    let error = Trainer::resume(folders[0].path(), envs(1), 1).err().unwrap().to_string();
    assert!(error.contains("of another run"), "{error}");
}

#[test]
fn a_finished_run_writes_its_policy_again_only_where_it_is_another() {
    use std::os::unix::fs::MetadataExt as _;
    let folder = tempfile::tempdir().unwrap();
    let mut config = config();
    config.env_steps = 25;
    let path = folder.path().join("policy.safetensors");
    let mut silent = |_: &Event| Ok(());
    let stop = AtomicBool::new(false);
    let mut trainer = Trainer::new(config.clone(), envs(1), 1).unwrap();
    trainer.run(Some(folder.path()), &mut silent, &stop).unwrap();
    let policy = fs::read(&path).unwrap();
    let file = || fs::metadata(&path).unwrap().ino();

    let mut again = || {
        let mut trainer = Trainer::resume(folder.path(), envs(1), 1).unwrap();
        trainer.run(Some(folder.path()), &mut silent, &stop).unwrap();
        assert!(fs::read(&path).unwrap() == policy);
    };
    let untouched = file();
    again();
    assert_eq!(file(), untouched);

    fs::remove_file(&path).unwrap();
    again();
    let other = Trainer::new(TrainConfig { seed: 2, ..config }, envs(1), 1).unwrap();
    other.policy().save(&path).unwrap();
    again();
}
