//! What the method needs to know about an environment.

use crate::control::Control;
use crate::goal::{Achieved, Desired, Stage, Tolerances};
use crate::names::Names;

pub use crate::symmetry::{Mirror, Permutation, SignedIndex};

/// Steps of the longest episode that a checkpoint has a number for.
const MOST_STEPS: usize = (1 << 30) - 1;

/// What holds for the life of an environment.
///
/// ```
/// use rher_core::{EnvSpec, Tolerances};
///
/// // One object, 10 numbers observed, 4 numbers in an action, episodes of 50 steps.
/// let mut spec = EnvSpec::<1>::new("push", 10, 4, 50);
/// spec.tolerances = Tolerances::uniform(0.02);
/// assert!(spec.validate().is_ok());
/// spec.subtasks = 3;
/// assert_eq!(
///     spec.validate().unwrap_err().to_string(),
///     "the environment `push` has `subtasks` = 3, expected 1 to 2, twice its objects"
/// );
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EnvSpec<const N: usize> {
    /// Name that runs and policies keep.
    pub name: String,
    /// Settings that it was made with, in any form; runs and policies keep them. Empty where there
    /// are none.
    pub variant: String,
    /// Length of an observation.
    pub obs_dim: usize,
    /// Length of an action; each of its numbers is in [−1, 1].
    pub action_dim: usize,
    /// Steps of an episode, the paper's T: none has more, and one has fewer where the environment
    /// ends it, see [`Env::end`].
    pub episode_steps: usize,
    /// How many sub-tasks to learn, from the first: 2 N, or fewer where the task ends sooner.
    pub subtasks: usize,
    /// How near counts as there.
    pub tolerances: Tolerances<N>,
    /// The scene's planes of symmetry, each perpendicular to another axis.
    pub mirrors: Vec<Mirror>,
    /// Other orders of objects that are alike; empty where every object is of its own kind.
    pub permutations: Vec<Permutation<N>>,
    /// Whether the task can be done in every order of its objects, so that a policy may choose one:
    /// `false` where one object has to be in its place before another, as in a tower. It takes
    /// `permutations` for every order.
    pub any_order: bool,
    /// What the numbers are, for a run that starts from one of another task; empty where nobody
    /// knows.
    pub names: Names,
    /// How fast it acts and what its numbers measure, for whoever deploys a policy.
    pub control: Control,
}

impl<const N: usize> EnvSpec<N> {
    /// Every one of the 2 N sub-tasks, tolerances of 5 cm, no symmetry, no names.
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
            any_order: false,
            names: Names::default(),
            control: Control::default(),
        }
    }

    /// The stage that ends the task; its sub-task is the whole task.
    ///
    /// # Panics
    ///
    /// If `subtasks` is not in 1..=2N, which [`EnvSpec::validate`] refuses.
    pub fn last_stage(&self) -> Stage<N> {
        let last = self.subtasks.checked_sub(1).and_then(Stage::from_index);
        last.expect("a valid specification has 1 to 2N sub-tasks")
    }

    /// Checks everything that the types do not.
    ///
    /// # Errors
    ///
    /// Names the first field that is wrong, with its value and with what was expected.
    pub fn validate(&self) -> Result<(), SpecError> {
        let wrong = |field: String, found: String, expected: String| {
            Err(SpecError { name: self.name.clone(), field, found, expected })
        };
        let dimensions = [
            ("obs_dim", self.obs_dim),
            ("action_dim", self.action_dim),
            ("episode_steps", self.episode_steps),
        ];
        if let Some((field, found)) = dimensions.into_iter().find(|(_, found)| *found == 0) {
            return wrong(field.to_owned(), found.to_string(), "at least 1".to_owned());
        }
        if self.episode_steps > MOST_STEPS {
            let (field, found) = ("episode_steps".to_owned(), self.episode_steps.to_string());
            return wrong(field, found, format!("at most {MOST_STEPS}"));
        }
        if !(1..=2 * N).contains(&self.subtasks) {
            let expected = format!("1 to {}, twice its objects", 2 * N);
            return wrong("subtasks".to_owned(), self.subtasks.to_string(), expected);
        }
        for (slot, tolerance) in self.tolerances.by_slot().enumerate() {
            if !(tolerance.is_finite() && tolerance >= 0.0) {
                let field = match slot {
                    0 => "tolerances.gripper".to_owned(),
                    object => format!("tolerances.objects[{}]", object - 1),
                };
                return wrong(
                    field,
                    tolerance.to_string(),
                    "a number of meters, at least 0".into(),
                );
            }
        }
        let tail = &self.tolerances.tail;
        let of_control = self.control.check(self.obs_dim, self.action_dim);
        let of_names = self.names.check(N, self.obs_dim, self.action_dim, tail.parts().len());
        if let Err((field, found, expected)) = of_names.and(of_control) {
            return wrong(field.to_owned(), found, expected);
        }
        for (index, mirror) in self.mirrors.iter().enumerate() {
            if let Err(problem) = mirror.check(self.obs_dim, self.action_dim, tail.numbers()) {
                return wrong(format!("mirrors[{index}]"), problem.found, problem.expected);
            }
        }
        for (index, permutation) in self.permutations.iter().enumerate() {
            if let Err(problem) = permutation.check(self.obs_dim) {
                return wrong(format!("permutations[{index}]"), problem.found, problem.expected);
            }
        }
        let orders = (1..=N).product::<usize>();
        if self.any_order && self.permutations.len() + 1 < orders {
            return wrong(
                "permutations".to_owned(),
                format!("{} orders", self.permutations.len()),
                format!("{}, for with `any_order` a policy may choose every other one", orders - 1),
            );
        }
        Ok(())
    }
}

/// The specification of an environment is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the environment `{name}` has `{field}` = {found}, expected {expected}")]
#[non_exhaustive]
pub struct SpecError {
    /// Name of the environment.
    pub name: String,
    /// Such as `subtasks` or `mirrors[0]`.
    pub field: String,
    /// Its value, or what is wrong in it.
    pub found: String,
    /// What it may be.
    pub expected: String,
}

/// An environment could not be reset or stepped.
///
/// ```
/// use rher_core::EnvError;
///
/// let error = EnvError::new("the camera is not connected");
/// assert_eq!(error.to_string(), "the camera is not connected");
/// ```
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
///
/// ```
/// use rher_core::testing::Carry;
/// use rher_core::{Env, Start};
///
/// let mut observation = [0.0; 2];
/// let Start { achieved, desired } = Carry::new().reset(7, &mut observation)?;
/// assert_eq!(observation[0], achieved.0.gripper.x);
/// assert_ne!(achieved.0.objects, *desired.objects());
/// # Ok::<(), rher_core::EnvError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start<const N: usize> {
    /// Where everything is.
    pub achieved: Achieved<N>,
    /// What the task asks for.
    pub desired: Desired<N>,
}

/// How an episode ended.
///
/// ```
/// use rher_core::testing::Carry;
/// use rher_core::{End, rollout};
///
/// let episode = rollout(&mut Carry::new(), 1, |_, _| Ok(()))?;
/// assert_eq!(episode.end, End::Truncated, "it had as many steps as an episode may have");
/// # Ok::<(), rher_core::RolloutError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum End {
    /// It was stopped by its number of steps or by whoever watches: what would have followed is
    /// unknown, and learned like what follows any other step.
    #[default]
    Truncated,
    /// The environment ended it because the task was done. Nothing follows: everything stays where
    /// it was. Under another goal the environment would have gone on.
    Solved,
    /// The environment ended it because nothing can be done any more, as when an object has fallen
    /// off a table. Nothing follows, whatever the goal was: everything stays where it was.
    Failed,
}

/// A scene with `N` objects, simulated or real.
///
/// There is no reward in it, which is a function of goals
/// ([`EncodedGoal::reward`](crate::goal::EncodedGoal::reward)). An episode has
/// [`EnvSpec::episode_steps`] steps, unless the environment ends it before ([`Env::end`]).
///
/// ```
/// use rher_core::{Achieved, Desired, Env, EnvError, EnvSpec, Position, Scene, Start};
///
/// /// A hand on a line that reaches for a place.
/// struct Line {
///     spec: EnvSpec<1>,
///     hand: f32,
///     target: Position,
/// }
///
/// impl Line {
///     fn observe(&self, observation: &mut [f32]) -> Achieved<1> {
///         observation[0] = self.hand;
///         let gripper = Position::new(self.hand, 0.0, 0.0);
///         Achieved(Scene::new(gripper, [self.target]))
///     }
/// }
///
/// impl Env<1> for Line {
///     fn spec(&self) -> &EnvSpec<1> {
///         &self.spec
///     }
///
///     fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
///         self.hand = 0.0;
///         self.target.x = (seed % 10) as f32 / 10.0;
///         let desired = Desired::of_task([self.target]);
///         Ok(Start { achieved: self.observe(observation), desired })
///     }
///
///     fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
///         self.hand += 0.1 * action[0];
///         Ok(self.observe(observation))
///     }
/// }
///
/// let mut spec = EnvSpec::new("line", 1, 1, 10);
/// spec.subtasks = 1;
/// let build = || Line { spec: spec.clone(), hand: 0.0, target: Position::origin() };
/// rher_core::testing::check_env(build)?;
/// # Ok::<(), rher_core::testing::CheckError>(())
/// ```
pub trait Env<const N: usize>: Send {
    /// Widths and limits.
    fn spec(&self) -> &EnvSpec<N>;

    /// Starts the episode of `seed` and writes its first observation, `[obs_dim]`.
    ///
    /// A simulated episode must depend on its seed and on the actions that follow, and on nothing
    /// else: reproducible runs rest on it.
    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError>;

    /// Carries out `action`, `[action_dim]`, each number in [−1, 1], and writes the observation after
    /// it, `[obs_dim]`.
    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError>;

    /// How the episode ended with the last step; `None` while it goes on, and in an environment
    /// that only ends by its number of steps.
    fn end(&self) -> Option<End> {
        None
    }

    /// The true scene now, where it is known and differs from the measured one that goals and
    /// rewards use.
    fn truth(&mut self) -> Option<Achieved<N>> {
        None
    }

    /// Starts an episode with the objects and targets of `start` and writes its first observation,
    /// where the environment can do that; `None` where it cannot, or not with this `start`.
    ///
    /// [`check_env`](crate::testing::check_env) checks symmetries with it.
    fn reset_to(
        &mut self,
        _start: &Start<N>,
        _observation: &mut [f32],
    ) -> Result<Option<Start<N>>, EnvError> {
        Ok(None)
    }
}

impl<E: Env<N> + ?Sized, const N: usize> Env<N> for Box<E> {
    fn spec(&self) -> &EnvSpec<N> {
        (**self).spec()
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        (**self).reset(seed, observation)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        (**self).step(action, observation)
    }

    fn end(&self) -> Option<End> {
        (**self).end()
    }

    fn truth(&mut self) -> Option<Achieved<N>> {
        (**self).truth()
    }

    fn reset_to(
        &mut self,
        start: &Start<N>,
        observation: &mut [f32],
    ) -> Result<Option<Start<N>>, EnvError> {
        (**self).reset_to(start, observation)
    }
}
