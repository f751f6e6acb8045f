//! What the method needs to know about an environment.

use crate::goal::{Achieved, Desired, Position, Tolerances};
use serde::{Deserialize, Serialize};

/// What holds for the life of an environment.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvSpec<const N: usize> {
    /// Name under which runs and policies remember it.
    pub name: String,
    /// Settings that it was made with, in the words of whoever makes it; runs and policies remember
    /// them. Empty where there are none.
    pub variant: String,
    /// Numbers in an observation.
    pub obs_dim: usize,
    /// Numbers in an action; each is in [−1, 1].
    pub action_dim: usize,
    /// Steps of every episode, the paper's T; episodes never end early.
    pub episode_steps: usize,
    /// How many sub-tasks to learn, from the first: 2 N, or fewer where the task ends sooner.
    pub subtasks: usize,
    /// How near counts as there.
    pub tolerances: Tolerances<N>,
    /// The scene's planes of symmetry, each perpendicular to another axis.
    pub mirrors: Vec<Mirror>,
    /// Other orders of objects that are alike; empty where every object is of its own kind.
    pub permutations: Vec<Permutation<N>>,
}

impl<const N: usize> EnvSpec<N> {
    /// Every one of the 2 N sub-tasks, tolerances of 5 cm, no symmetry.
    pub fn new(name: &str, obs_dim: usize, action_dim: usize, episode_steps: usize) -> Self {
        Self {
            name: name.to_owned(),
            variant: String::new(),
            obs_dim,
            action_dim,
            episode_steps,
            subtasks: 2 * N,
            tolerances: Tolerances::uniform(0.05),
            mirrors: Vec::new(),
            permutations: Vec::new(),
        }
    }
}

/// A plane of symmetry, perpendicular to one world axis: every episode has a mirror image that
/// obeys the same physics.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    /// The world axis that is flipped: 0, 1 or 2.
    pub axis: usize,
    /// Where the plane crosses that axis, in metres.
    pub centre: f32,
    /// One entry for each number of an observation.
    pub observation: Vec<SignedIndex>,
    /// One entry for each number of an action.
    pub action: Vec<SignedIndex>,
}

/// Objects that are alike in another order: every episode in which they change names obeys the
/// same physics. Actions are as they were.
#[derive(Clone, Debug, PartialEq)]
pub struct Permutation<const N: usize> {
    /// For each place in the order, which object comes there.
    pub order: [usize; N],
    /// One entry for each number of an observation.
    pub observation: Vec<SignedIndex>,
}

/// One number of a vector's image under a symmetry: `sign * original[from] + offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignedIndex {
    /// Index in the original vector.
    pub from: usize,
    /// 1 or −1.
    pub sign: f32,
    /// Twice the mirror's place for a coordinate along the flipped axis, 0 for all else.
    pub offset: f32,
}

impl Mirror {
    /// The mirror image of a point.
    #[must_use]
    #[inline]
    pub fn position(&self, position: Position) -> Position {
        let mut mirrored = position;
        mirrored[self.axis] = 2.0 * self.centre - position[self.axis];
        mirrored
    }
}

impl SignedIndex {
    /// The images under one symmetry and then another; no entries are no change.
    pub(crate) fn then(first: &[Self], second: &[Self]) -> Vec<Self> {
        let both = |second: &Self| match first.get(second.from) {
            None => *second,
            Some(Self { from, sign, offset }) => Self {
                from: *from,
                sign: second.sign * sign,
                offset: second.sign * offset + second.offset,
            },
        };
        second.iter().map(both).collect()
    }

    /// This number of the image of `original`.
    #[inline]
    pub fn of(&self, original: &[f32]) -> f32 {
        self.sign * original[self.from] + self.offset
    }

    /// Writes the image of `original` to `image`; all three are equally long.
    #[inline]
    pub fn apply(images: &[Self], original: &[f32], image: &mut [f32]) {
        debug_assert!(images.len() == original.len() && original.len() == image.len());
        for (out, number) in image.iter_mut().zip(images) {
            *out = number.of(original);
        }
    }
}

/// An environment could not be reset or stepped.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct EnvError(#[from] Box<dyn std::error::Error + Send + Sync>);

impl EnvError {
    /// Wraps whatever went wrong.
    pub fn new(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self(error.into())
    }
}

/// The beginning of an episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start<const N: usize> {
    /// Where everything is.
    pub achieved: Achieved<N>,
    /// What the task asks for.
    pub desired: Desired<N>,
}

/// A scene with `N` objects, simulated or real.
///
/// There is no reward and no end in it: the reward is a function of goals
/// ([`EncodedGoal::reward`](crate::goal::EncodedGoal::reward)), and every episode has
/// [`EnvSpec::episode_steps`] steps.
pub trait Env<const N: usize>: Send {
    /// Widths and limits.
    fn spec(&self) -> &EnvSpec<N>;

    /// Starts the episode that belongs to `seed` and writes its first observation.
    ///
    /// A simulated episode must depend on nothing but its seed and the actions that follow:
    /// reproducible runs rest on it.
    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError>;

    /// Acts for one step and writes the observation after it.
    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError>;

    /// Where everything really is, if that is known and is not what is achieved: goals and rewards
    /// are of what sensors tell.
    fn truth(&mut self) -> Option<Achieved<N>> {
        None
    }
}
