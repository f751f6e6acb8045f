//! Episodes that end before their last step.

use crate::toy::Magnet;
#[cfg(feature = "train")]
use crate::toy::{Lines, small};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::batch::Batch;
use rher_core::config::Preset;
use rher_core::env::{End, Env, EnvError, EnvSpec, Start};
use rher_core::episode::{Episode, rollout};
use rher_core::goal::{Achieved, Desired, EncodedGoal, Position, Scene, Stage};
use rher_core::input::InputEncoder;
use rher_core::relabel::Relabeler;
use rher_core::replay::{Replay, StepIndex};
use std::convert::Infallible;

/// A [`Magnet`] that ends an episode once its task is done, once the gripper is near the right edge,
/// and after as many steps as the seed says.
struct Ending {
    inner: Magnet<1>,
    desired: Desired<1>,
    steps: u64,
    end: Option<End>,
}

impl Ending {
    fn new() -> Self {
        let desired = Desired::of_task([Position::origin()]);
        Self { inner: Magnet::new(), desired, steps: 0, end: None }
    }
}

impl Env<1> for Ending {
    fn spec(&self) -> &EnvSpec<1> {
        self.inner.spec()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
        let start = self.inner.reset(seed, observation)?;
        (self.desired, self.steps, self.end) = (start.desired, 5 + seed % 40, None);
        Ok(start)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
        let achieved = self.inner.step(action, observation)?;
        self.steps -= 1;
        let goal = EncodedGoal::new(Stage::place(0), &achieved, &self.desired);
        self.end = if goal.is_met(&achieved, &self.spec().tolerances) {
            Some(End::Solved)
        } else if achieved.0.gripper.x > 0.85 {
            Some(End::Failed)
        } else {
            (self.steps == 0).then_some(End::Truncated)
        };
        Ok(achieved)
    }

    fn end(&self) -> Option<End> {
        self.end
    }
}

/// Episodes in which the gripper goes to the object and drags it to its target, or misses it.
fn episodes(count: u64) -> Vec<Episode<1>> {
    let mut env = Ending::new();
    let play = |seed| {
        rollout(&mut env, seed, |view, action| {
            let Scene { gripper, objects: [object], .. } = view.achieved.0;
            let place = if nalgebra::distance(&gripper, &object) < 0.1 {
                view.desired.objects()[0]
            } else {
                object
            };
            let aside = if seed % 3 == 0 { 3.0 } else { 0.0 };
            let way = 10.0 * (place - gripper);
            action.copy_from_slice(&[way.x + aside, way.y, 1.0]);
            Ok(())
        })
        .unwrap()
    };
    (0..count).map(play).collect()
}

fn of_end(episodes: &[Episode<1>], end: End) -> Vec<&Episode<1>> {
    episodes.iter().filter(|episode| episode.end == end).collect()
}

#[test]
fn an_episode_is_as_long_as_the_environment_lets_it_be() {
    let episodes = episodes(60);
    for end in [End::Solved, End::Failed, End::Truncated] {
        let some = of_end(&episodes, end);
        assert!(some.len() > 3, "{} ended {end:?}", some.len());
        assert!(some.iter().any(|episode| episode.steps() < 25), "{end:?}");
    }
    for Episode { observations, achieved, actions, .. } in &episodes {
        assert!((2..=26).contains(&achieved.len()));
        assert_eq!(observations.len(), 4 * achieved.len());
        assert_eq!(actions.len(), 3 * (achieved.len() - 1));
        assert_eq!(observations[4 * achieved.len() - 4], achieved[achieved.len() - 1].0.gripper.x);
    }
}

#[test]
fn every_step_that_was_taken_is_drawn_and_no_other() {
    let spec = Magnet::<1>::new().spec().clone();
    // Some make room for others.
    let (capacity, count) = (20, 50);
    let episodes = episodes(count);
    let mut replay = Replay::new(&spec, capacity * 25);
    for episode in &episodes {
        replay.push(episode);
    }
    let kept = &episodes[count as usize - capacity..];
    assert_eq!(replay.newest(capacity).collect::<Vec<_>>(), kept);
    let ends = replay.newest_ends(capacity).map(|([_, end], _)| end);
    assert!(ends.eq(kept.iter().map(|episode| episode.achieved[episode.steps()])));
    let all: usize = kept.iter().map(Episode::steps).sum();
    assert_eq!(replay.newest_steps(capacity), all);
    let of_three: usize = kept[17..].iter().map(Episode::steps).sum();
    assert_eq!(replay.newest_steps(3), of_three);

    let restored = Replay::restore(&spec, capacity * 25, count, |index| {
        Ok::<_, Infallible>(episodes[index as usize].clone())
    })
    .unwrap();
    let mut counts = vec![[0_u32; 25]; capacity];
    let (mut rng, mut same) = (ChaCha8Rng::seed_from_u64(1), ChaCha8Rng::seed_from_u64(1));
    let draws = 200 * all as u32;
    for _ in 0..draws {
        let at = replay.draw(&mut rng);
        assert_eq!(restored.draw(&mut same), at);
        counts[at.slot][at.step] += 1;
    }
    for (slot, counts) in counts.iter().enumerate() {
        let steps = replay.steps(slot);
        for (step, count) in counts.iter().enumerate() {
            let at = StepIndex { slot, step };
            assert_eq!(replay.end(at).is_some(), step + 1 == steps);
            // Five standard deviations from 200.
            let expected = if step < steps { 129..=271 } else { 0..=0 };
            assert!(expected.contains(count), "{count} draws of step {step} of {steps}");
        }
    }
}

/// Rows of the sub-task of `stage`, from a replay of these episodes: for each its step in the
/// episode, whether it is rewarded and whether it is an end.
fn rows(episodes: &[&Episode<1>], stage: Stage<1>, hindsight: f32) -> Vec<(usize, bool, bool)> {
    let spec = Magnet::<1>::new().spec().clone();
    let mut replay = Replay::new(&spec, 25 * episodes.len());
    for episode in episodes {
        replay.push(episode);
    }
    let relay =
        rher_core::config::RelayConfig { hindsight, ..Preset::Paper.config("ends", 1).relay };
    let encoder = InputEncoder::new(&relay, &spec);
    let mut batch = Batch::zeros(4000, encoder.width(), 3);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut relabeler = Relabeler::new(&relay, &spec);
    relabeler.draw(&replay, &encoder, stage, &mut batch, 0..4000, &mut rng);
    let left = |row: usize| {
        let seen = &batch.next_inputs[row * batch.input_dim..][..4];
        let step_of = |episode: &&Episode<1>| {
            let frames = episode.observations.chunks_exact(4).skip(1);
            frames.zip((0..episode.steps()).rev()).find(|(frame, _)| *frame == seen).map(|it| it.1)
        };
        episodes.iter().find_map(step_of).unwrap()
    };
    (0..4000).map(|row| (left(row), batch.rewards[row] == 0.0, batch.ended[row])).collect()
}

#[test]
fn a_row_ends_where_its_episode_did() {
    let episodes = episodes(60);
    let (reach, place) = (Stage::FIRST, Stage::place(0));
    for stage in [reach, place] {
        for (left, _, ended) in rows(&of_end(&episodes, End::Truncated), stage, 0.8) {
            assert!(!ended, "{left} steps before a time-out");
        }
        for (left, _, ended) in rows(&of_end(&episodes, End::Failed), stage, 0.8) {
            assert_eq!(ended, left == 0, "{left} steps before a failure");
        }
    }
    // A task that is done ends the rows that ask for it, wherever they are in the episode, and rows
    // that ask for something else do not end where the episode did.
    let solved = of_end(&episodes, End::Solved);
    let of_place = rows(&solved, place, 0.8);
    assert!(of_place.iter().all(|(_, met, ended)| met == ended));
    assert!(of_place.iter().any(|(left, met, _)| *left > 0 && *met));
    let of_reach = rows(&solved, reach, 0.8);
    assert!(of_reach.iter().all(|(left, met, ended)| *ended == (*left == 0 && *met)));
    let mut apart = solved[0].clone();
    apart.achieved.last_mut().unwrap().0.gripper.x -= 0.5;
    let of_reach = rows(&[&apart], reach, 0.0);
    assert!(of_reach.iter().all(|(left, met, ended)| *left > 0 || !met && !ended));
}

#[cfg(feature = "train")]
mod trained {
    use super::*;
    use rher_core::event::{Metrics, Seconds};
    use rher_core::train::{Finish, Trainer};
    use std::sync::atomic::AtomicBool;

    fn trainer(env_steps: u64) -> Trainer<1, Ending> {
        let mut config = small("magnet", 1);
        config.env_steps = env_steps;
        config.agent.hidden = vec![16, 16];
        config.replay.capacity = 30 * 25;
        config.replay.updates_per_episode = 10;
        Trainer::new(config, vec![Ending::new()], 1).unwrap()
    }

    /// What is found in evaluations, without the time.
    fn timeless(lines: Lines) -> Vec<Metrics> {
        let timeless = |line| Metrics { wall_s: 0.0, time: Seconds::default(), ..line };
        lines.0.into_iter().map(timeless).collect()
    }

    #[test]
    fn steps_are_those_that_were_taken_and_updates_belong_to_them() {
        let mut trainer = trainer(1000);
        trainer.run(None, &mut Lines::default(), &AtomicBool::new(false)).unwrap();
        let progress = trainer.progress();
        assert!((1000..1025).contains(&progress.env_steps), "{progress:?}");
        assert!(progress.episodes > 45, "{progress:?}");
        assert_eq!(progress.updates, progress.env_steps * 10 / 25);
    }

    #[test]
    fn stopped_and_resumed_a_run_ends_with_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let mut straight = Lines::default();
        let mut whole = trainer(2500);
        whole.run(None, &mut straight, &AtomicBool::new(false)).unwrap();

        let mut parts = Lines::default();
        let mut trainer = trainer(2500);
        for stops in 0_u64.. {
            let stop = AtomicBool::new(false);
            let finish = std::thread::scope(|scope| {
                scope.spawn(|| {
                    std::thread::sleep(std::time::Duration::from_micros(stops * 7919 % 40_000));
                    stop.store(true, std::sync::atomic::Ordering::Relaxed);
                });
                trainer.run(Some(folder.path()), &mut parts, &stop).unwrap()
            });
            if finish == Finish::StepsSpent {
                assert!(stops > 5, "{stops} stops");
                break;
            }
            trainer = Trainer::resume(folder.path(), vec![Ending::new()], 1).unwrap();
        }
        assert_eq!(timeless(parts), timeless(straight));
        assert_eq!(trainer.policy(), whole.policy());
    }
}
