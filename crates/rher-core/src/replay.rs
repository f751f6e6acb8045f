//! Replay of whole episodes in a fixed amount of memory.

use crate::env::EnvSpec;
use crate::episode::Episode;
use crate::goal::{Achieved, Desired};
use rand::{Rng, RngExt as _};

/// A ring of whole episodes in flat columns; the oldest episode makes room for the newest.
///
/// Observations are raw, goals are what the task asked for: both are normalised and relabelled
/// when they are drawn.
#[derive(Clone, Debug)]
pub struct Replay<const N: usize> {
    observation: usize,
    action: usize,
    steps: usize,
    capacity: usize,
    pushed: u64,
    observations: Vec<f32>,
    achieved: Vec<Achieved<N>>,
    actions: Vec<f32>,
    desired: Vec<Desired<N>>,
}

/// One step of a stored episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepIndex {
    /// Place of the episode in the ring.
    pub slot: usize,
    /// Step in the episode, 0 to T − 1.
    pub step: usize,
}

impl<const N: usize> Replay<N> {
    /// An empty replay for `transitions` steps of such episodes, but for one episode at least.
    pub fn new(spec: &EnvSpec<N>, transitions: usize) -> Self {
        let EnvSpec { observation, action, episode_steps: steps, .. } = *spec;
        let capacity = (transitions / steps).max(1);
        Self {
            observation,
            action,
            steps,
            capacity,
            pushed: 0,
            observations: Vec::with_capacity(capacity * (steps + 1) * observation),
            achieved: Vec::with_capacity(capacity * (steps + 1)),
            actions: Vec::with_capacity(capacity * steps * action),
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

    /// Episodes that are stored.
    pub fn episodes(&self) -> usize {
        self.desired.len()
    }

    /// Episodes that were ever stored, those that made room included.
    pub fn pushed(&self) -> u64 {
        self.pushed
    }

    /// Stores an episode, its actions clipped to [−1, 1].
    ///
    /// # Panics
    ///
    /// If its widths or length are not those the replay was made for.
    pub fn push(&mut self, episode: &Episode<N>) {
        let Episode { desired, observations, achieved, actions } = episode;
        assert_eq!(achieved.len(), self.steps + 1, "frames of an episode");
        assert_eq!(observations.len(), (self.steps + 1) * self.observation, "observations");
        assert_eq!(actions.len(), self.steps * self.action, "actions");
        if self.episodes() < self.capacity {
            self.observations.extend_from_slice(observations);
            self.achieved.extend_from_slice(achieved);
            self.actions.extend_from_slice(actions);
            self.desired.push(*desired);
        } else {
            let slot = (self.pushed % self.capacity as u64) as usize;
            let place = |width: usize| slot * width..(slot + 1) * width;
            self.observations[place(observations.len())].copy_from_slice(observations);
            self.achieved[place(achieved.len())].copy_from_slice(achieved);
            self.actions[place(actions.len())].copy_from_slice(actions);
            self.desired[slot] = *desired;
        }
        let slot = (self.pushed % self.capacity as u64) as usize;
        for number in &mut self.actions[slot * actions.len()..(slot + 1) * actions.len()] {
            *number = number.clamp(-1.0, 1.0);
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

    fn episode(&self, slot: usize) -> Episode<N> {
        let frames = slot * (self.steps + 1)..(slot + 1) * (self.steps + 1);
        Episode {
            desired: self.desired[slot],
            observations: self.observations
                [frames.start * self.observation..frames.end * self.observation]
                .to_vec(),
            achieved: self.achieved[frames].to_vec(),
            actions: self.actions
                [slot * self.steps * self.action..(slot + 1) * self.steps * self.action]
                .to_vec(),
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

    /// All `T + 1` scenes of an episode.
    pub fn achieved(&self, slot: usize) -> &[Achieved<N>] {
        &self.achieved[slot * (self.steps + 1)..(slot + 1) * (self.steps + 1)]
    }

    /// Observations before and after a step.
    pub fn observations(&self, StepIndex { slot, step }: StepIndex) -> (&[f32], &[f32]) {
        let start = (slot * (self.steps + 1) + step) * self.observation;
        self.observations[start..start + 2 * self.observation].split_at(self.observation)
    }

    /// The action of a step.
    pub fn action(&self, StepIndex { slot, step }: StepIndex) -> &[f32] {
        let start = (slot * self.steps + step) * self.action;
        &self.actions[start..start + self.action]
    }
}
