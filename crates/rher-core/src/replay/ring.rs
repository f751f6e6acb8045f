//! Replay of whole episodes in a fixed amount of memory.

use super::prefetch::{CACHE_LINE, prefetch};
use crate::env::{End, EnvSpec};
use crate::episode::Episode;
use crate::goal::{Achieved, Desired, Scene};
use rand::{Rng, RngExt as _};
use std::ops::Range;

/// A ring of whole episodes, frame by frame; the oldest episode makes room for the newest. Each has
/// room for as many steps as an episode may have.
///
/// Observations are raw, goals are what the task asked for: both are normalized and relabeled
/// when they are drawn.
#[derive(Clone, Debug)]
pub struct Replay<const N: usize> {
    observation: usize,
    action: usize,
    /// Numbers of an object's tail.
    tail: usize,
    steps: usize,
    capacity: usize,
    pushed: u64,
    /// `[episodes, T + 1, observation ‖ positions ‖ tails ‖ action]`: a step is read in one place.
    /// The last frame of an episode has no action.
    frames: Vec<f32>,
    /// `[episodes, positions ‖ tails]`.
    desired: Vec<f32>,
    extents: Vec<Extent>,
    /// Stored episodes that have not as many steps as fit, or were not truncated.
    ended: usize,
    /// Stored episodes that ended because the task was done.
    solved: usize,
}

/// How much of its place in the ring an episode fills.
#[derive(Clone, Copy, Debug)]
struct Extent {
    steps: usize,
    end: End,
}

/// One step of a stored episode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepIndex {
    /// Place of the episode in the ring.
    pub slot: usize,
    /// Step in the episode, from 0 to one less than it has.
    pub step: usize,
}

impl<const N: usize> Replay<N> {
    /// An empty replay for `transitions` steps of such episodes, but for one episode at least.
    pub fn new(spec: &EnvSpec<N>, transitions: usize) -> Self {
        let EnvSpec { obs_dim: observation, action_dim: action, episode_steps: steps, .. } = *spec;
        let capacity = (transitions / steps).max(1);
        let tail = spec.tolerances.tail.numbers();
        Self {
            observation,
            action,
            tail,
            steps,
            capacity,
            pushed: 0,
            frames: Vec::with_capacity(capacity * (steps + 1) * frame_width(spec)),
            desired: Vec::with_capacity(capacity * Desired::<N>::width(tail)),
            extents: Vec::with_capacity(capacity),
            ended: 0,
            solved: 0,
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

    /// Steps that every episode has room for.
    pub fn room(&self) -> usize {
        self.steps
    }

    /// Numbers of an object's tail.
    #[cfg(feature = "train")]
    pub(crate) fn tail(&self) -> usize {
        self.tail
    }

    /// Steps of the episode in a place of the ring.
    pub fn steps(&self, slot: usize) -> usize {
        if self.ended == 0 { self.steps } else { self.extents[slot].steps }
    }

    /// How an episode ended with this step; `None` if it has another one.
    pub fn end(&self, StepIndex { slot, step }: StepIndex) -> Option<End> {
        if step + 1 != self.steps(slot) {
            return None;
        }
        Some(if self.ended == 0 { End::Truncated } else { self.extents[slot].end })
    }

    /// Whether a stored episode ended because the task was done.
    pub fn ends_when_solved(&self) -> bool {
        self.solved > 0
    }

    /// Episodes that are stored.
    pub fn episodes(&self) -> usize {
        self.extents.len()
    }

    /// Episodes that were ever stored, those that made room included.
    pub fn pushed(&self) -> u64 {
        self.pushed
    }

    /// Stores an episode.
    ///
    /// # Panics
    ///
    /// If its widths are not those the replay was made for, or if it has more steps than fit, or none.
    pub fn push(&mut self, episode: &Episode<N>) {
        let Episode { desired, observations, achieved, actions, end } = episode;
        let steps = episode.steps();
        assert!((1..=self.steps).contains(&steps), "{steps} steps, expected 1 to {}", self.steps);
        assert_eq!(observations.len(), (steps + 1) * self.observation, "observations");
        assert_eq!(actions.len(), steps * self.action, "actions");
        let extent = Extent { steps, end: *end };
        let slot = (self.pushed % self.capacity as u64) as usize;
        if slot == self.episodes() {
            self.extents.push(extent);
            self.desired.resize(self.episodes() * Desired::<N>::width(self.tail), 0.0);
            self.frames.resize(self.episodes() * (self.steps + 1) * self.width(), 0.0);
        } else {
            let before = std::mem::replace(&mut self.extents[slot], extent);
            self.ended -= usize::from(self.is_ended(before));
            self.solved -= usize::from(before.end == End::Solved);
        }
        let goal = self.goal(slot);
        for (stored, number) in self.desired[goal].iter_mut().zip(desired.numbers(self.tail)) {
            *stored = number;
        }
        self.ended += usize::from(self.is_ended(extent));
        self.solved += usize::from(extent.end == End::Solved);
        let Self { observation: seen, action: acted, .. } = *self;
        let (start, width) = (self.start(StepIndex { slot, step: 0 }), self.width());
        let frames = self.frames[start..].chunks_exact_mut(width);
        for (step, (frame, scene)) in frames.zip(achieved).enumerate() {
            let (head, tail) = frame.split_at_mut(seen);
            let (numbers, action) = tail.split_at_mut(Scene::<N>::width(self.tail));
            head.copy_from_slice(&observations[step * seen..(step + 1) * seen]);
            for (stored, number) in numbers.iter_mut().zip(scene.0.numbers(self.tail)) {
                *stored = number;
            }
            if step < steps {
                action.copy_from_slice(&actions[step * acted..(step + 1) * acted]);
            }
        }
        self.pushed += 1;
    }

    /// Whether it is not an episode of all steps that was truncated.
    fn is_ended(&self, Extent { steps, end }: Extent) -> bool {
        steps < self.steps || end != End::Truncated
    }

    /// Steps of the `count` episodes stored last, together. Those that have made room already count
    /// as the mean of the others.
    ///
    /// # Panics
    ///
    /// If nothing is stored.
    pub fn newest_steps(&self, count: usize) -> usize {
        let stored = count.min(self.episodes());
        let steps = (self.pushed - stored as u64..self.pushed)
            .map(|index| self.steps((index % self.capacity as u64) as usize));
        steps.sum::<usize>() * count / stored
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
    ) -> impl Iterator<Item = ([Achieved<N>; 2], Desired<N>)> {
        assert!(count <= self.episodes(), "{count} of {} episodes", self.episodes());
        (self.pushed - count as u64..self.pushed).map(|index| {
            let slot = (index % self.capacity as u64) as usize;
            let ends = [0, self.steps(slot)].map(|step| self.scene(StepIndex { slot, step }));
            (ends, self.desired(slot))
        })
    }

    fn episode(&self, slot: usize) -> Episode<N> {
        let steps = self.steps(slot);
        let frames = || (0..=steps).map(move |step| StepIndex { slot, step });
        Episode {
            desired: self.desired(slot),
            observations: frames().flat_map(|index| self.observation(index)).copied().collect(),
            achieved: frames().map(|index| self.scene(index)).collect(),
            actions: frames().take(steps).flat_map(|index| self.action(index)).copied().collect(),
            end: self.extents[slot].end,
        }
    }

    /// Draws a step, each with the same chance.
    ///
    /// # Panics
    ///
    /// If nothing is stored.
    pub fn draw(&self, rng: &mut impl Rng) -> StepIndex {
        loop {
            let index = rng.random_range(0..self.episodes() * self.steps);
            let (slot, step) = (index / self.steps, index % self.steps);
            if step < self.steps(slot) {
                return StepIndex { slot, step };
            }
        }
    }

    /// What the task asked for in an episode.
    pub fn desired(&self, slot: usize) -> Desired<N> {
        Desired::read(&self.desired[self.goal(slot)], self.tail)
    }

    /// The observation at a step, or after the last.
    pub fn observation(&self, index: StepIndex) -> &[f32] {
        let start = self.start(index);
        &self.frames[start..start + self.observation]
    }

    /// The scene at a step, or after the last.
    pub fn scene(&self, index: StepIndex) -> Achieved<N> {
        let start = self.start(index) + self.observation;
        let end = start + Scene::<N>::width(self.tail);
        Achieved(Scene::read(&self.frames[start..end], self.tail))
    }

    /// The action of a step.
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
            None => prefetch(&self.desired[self.goal(slot).start]),
        }
    }

    /// Numbers in a frame.
    fn width(&self) -> usize {
        self.observation + Scene::<N>::width(self.tail) + self.action
    }

    /// Where the goal of an episode is.
    fn goal(&self, slot: usize) -> Range<usize> {
        let width = Desired::<N>::width(self.tail);
        slot * width..(slot + 1) * width
    }

    /// Where a frame begins.
    fn start(&self, StepIndex { slot, step }: StepIndex) -> usize {
        (slot * (self.steps + 1) + step) * self.width()
    }
}

/// Numbers in a frame of the replay of environments like `spec`: an observation, a scene, an action.
pub(crate) fn frame_width<const N: usize>(spec: &EnvSpec<N>) -> usize {
    spec.obs_dim + Scene::<N>::width(spec.tolerances.tail.numbers()) + spec.action_dim
}
