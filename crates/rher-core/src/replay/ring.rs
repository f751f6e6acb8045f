//! Replay of whole episodes in a fixed amount of memory.

use super::prefetch::{CACHE_LINE, prefetch};
use crate::env::EnvSpec;
use crate::episode::Episode;
use crate::goal::{Achieved, Desired, Position, Scene};
use rand::{Rng, RngExt as _};
use std::array;

/// A ring of whole episodes, frame by frame; the oldest episode makes room for the newest.
///
/// Observations are raw, goals are what the task asked for: both are normalized and relabeled
/// when they are drawn.
#[derive(Clone, Debug)]
pub struct Replay<const N: usize> {
    observation: usize,
    action: usize,
    steps: usize,
    capacity: usize,
    pushed: u64,
    /// `[episodes, T + 1, observation ‖ scene ‖ action]`: a step is read in one place. The last
    /// frame of an episode has no action.
    frames: Vec<f32>,
    desired: Vec<Desired<N>>,
}

/// One step of a stored episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepIndex {
    /// Place of the episode in the ring.
    pub slot: usize,
    /// Step in the episode, 0 to T − 1.
    pub step: usize,
}

impl<const N: usize> Replay<N> {
    /// An empty replay for `transitions` steps of such episodes, but for one episode at least.
    pub fn new(spec: &EnvSpec<N>, transitions: usize) -> Self {
        let EnvSpec { obs_dim: observation, action_dim: action, episode_steps: steps, .. } = *spec;
        let capacity = (transitions / steps).max(1);
        Self {
            observation,
            action,
            steps,
            capacity,
            pushed: 0,
            frames: Vec::with_capacity(capacity * (steps + 1) * width::<N>(observation, action)),
            desired: Vec::with_capacity(capacity),
        }
    }

    /// A replay into which `pushed` episodes were stored before; `read` gets the ones that fit,
    /// by number.
    pub fn restore<E>(
        spec: &EnvSpec<N>,
        transitions: usize,
        pushed: u64,
        mut read: impl FnMut(u64) -> Result<Episode<N>, E>,
    ) -> Result<Self, E> {
        let mut replay = Self::new(spec, transitions);
        let capacity = replay.capacity as u64;
        let stored = pushed.min(capacity);
        for slot in 0..stored {
            let rounds = (pushed - 1 - slot) / capacity;
            replay.push(&read(rounds * capacity + slot)?);
        }
        replay.pushed = pushed;
        Ok(replay)
    }

    /// Episodes that fit.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Steps of an episode, T.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Episodes that are stored.
    pub fn episodes(&self) -> usize {
        self.desired.len()
    }

    /// Episodes that were ever stored, those that made room included.
    pub fn pushed(&self) -> u64 {
        self.pushed
    }

    /// Stores an episode.
    ///
    /// # Panics
    ///
    /// If its widths or length are not those the replay was made for.
    pub fn push(&mut self, episode: &Episode<N>) {
        let Episode { desired, observations, achieved, actions } = episode;
        assert_eq!(achieved.len(), self.steps + 1, "frames of an episode");
        assert_eq!(observations.len(), (self.steps + 1) * self.observation, "observations");
        assert_eq!(actions.len(), self.steps * self.action, "actions");
        let slot = (self.pushed % self.capacity as u64) as usize;
        if slot == self.episodes() {
            self.desired.push(*desired);
            self.frames.resize(self.frames.len() + (self.steps + 1) * self.width(), 0.0);
        } else {
            self.desired[slot] = *desired;
        }
        let Self { observation: seen, action: acted, .. } = *self;
        let (start, width) = (self.start(StepIndex { slot, step: 0 }), self.width());
        let frames = self.frames[start..].chunks_exact_mut(width);
        for (step, (frame, scene)) in frames.zip(achieved).enumerate() {
            let (head, tail) = frame.split_at_mut(seen);
            let (places, action) = tail.split_at_mut(3 * (N + 1));
            head.copy_from_slice(&observations[step * seen..(step + 1) * seen]);
            for (place, position) in places.chunks_exact_mut(3).zip(scene.0.places()) {
                place.copy_from_slice(position.coords.as_slice());
            }
            if step < self.steps {
                action.copy_from_slice(&actions[step * acted..(step + 1) * acted]);
            }
        }
        self.pushed += 1;
    }

    /// The `count` episodes stored last, oldest first.
    ///
    /// # Panics
    ///
    /// If fewer are stored.
    pub fn newest(&self, count: usize) -> impl Iterator<Item = Episode<N>> {
        assert!(count <= self.episodes(), "{count} of {} episodes", self.episodes());
        (self.pushed - count as u64..self.pushed)
            .map(|index| self.episode((index % self.capacity as u64) as usize))
    }

    /// The first and the last scene of the `count` episodes stored last, oldest first, and what was
    /// asked for in them.
    ///
    /// # Panics
    ///
    /// If fewer are stored.
    pub fn newest_ends(
        &self,
        count: usize,
    ) -> impl Iterator<Item = ([Achieved<N>; 2], &Desired<N>)> {
        assert!(count <= self.episodes(), "{count} of {} episodes", self.episodes());
        (self.pushed - count as u64..self.pushed).map(|index| {
            let slot = (index % self.capacity as u64) as usize;
            let ends = [0, self.steps].map(|step| self.scene(StepIndex { slot, step }));
            (ends, &self.desired[slot])
        })
    }

    fn episode(&self, slot: usize) -> Episode<N> {
        let frames = || (0..=self.steps).map(move |step| StepIndex { slot, step });
        Episode {
            desired: self.desired[slot],
            observations: frames().flat_map(|index| self.observation(index)).copied().collect(),
            achieved: frames().map(|index| self.scene(index)).collect(),
            actions: frames()
                .take(self.steps)
                .flat_map(|index| self.action(index))
                .copied()
                .collect(),
        }
    }

    /// Draws a step, each with the same chance.
    ///
    /// # Panics
    ///
    /// If nothing is stored.
    pub fn draw(&self, rng: &mut impl Rng) -> StepIndex {
        let index = rng.random_range(0..self.episodes() * self.steps);
        StepIndex { slot: index / self.steps, step: index % self.steps }
    }

    /// What the task asked for in an episode.
    pub fn desired(&self, slot: usize) -> &Desired<N> {
        &self.desired[slot]
    }

    /// The observation at a step, 0 to T.
    pub fn observation(&self, index: StepIndex) -> &[f32] {
        let start = self.start(index);
        &self.frames[start..start + self.observation]
    }

    /// The scene at a step, 0 to T.
    pub fn scene(&self, index: StepIndex) -> Achieved<N> {
        let start = self.start(index) + self.observation;
        let numbers = &self.frames[start..start + 3 * (N + 1)];
        let place = |thing: usize| {
            Position::new(numbers[3 * thing], numbers[3 * thing + 1], numbers[3 * thing + 2])
        };
        Achieved(Scene { gripper: place(0), objects: array::from_fn(|object| place(object + 1)) })
    }

    /// The action of a step, 0 to T − 1.
    pub fn action(&self, index: StepIndex) -> &[f32] {
        let end = self.start(index) + self.width();
        &self.frames[end - self.action..end]
    }

    /// Has what is stored of a step and of the next, and the goal of step `later` or of the task,
    /// fetched from memory; nothing waits for it.
    pub fn prefetch(&self, StepIndex { slot, step }: StepIndex, later: Option<usize>) {
        let start = self.start(StepIndex { slot, step });
        let frames = &self.frames[start..start + 2 * self.width()];
        frames.iter().step_by(CACHE_LINE / size_of::<f32>()).for_each(prefetch);
        prefetch(&frames[frames.len() - 1]);
        match later {
            Some(step) => {
                prefetch(&self.frames[self.start(StepIndex { slot, step }) + self.observation]);
            }
            None => prefetch(&self.desired[slot]),
        }
    }

    /// Numbers in a frame.
    fn width(&self) -> usize {
        width::<N>(self.observation, self.action)
    }

    /// Where a frame begins.
    fn start(&self, StepIndex { slot, step }: StepIndex) -> usize {
        (slot * (self.steps + 1) + step) * self.width()
    }
}

/// Numbers in a frame: an observation, the places of the gripper and of `N` objects, an action.
fn width<const N: usize>(observation: usize, action: usize) -> usize {
    observation + 3 * (N + 1) + action
}
