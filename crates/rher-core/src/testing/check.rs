//! Checks of environments of your own, in one call.

use crate::env::{Env, EnvError, EnvSpec, SignedIndex, SpecError, Start};
use crate::goal::{Achieved, Desired, Position, Scene, TAIL_NUMBERS, Tails};
use crate::seed::{Purpose, Seed};
use rand::RngExt as _;
use std::fmt;

/// Episodes that are played for each check.
const EPISODES: u64 = 5;

/// Steps for which a scene and its mirror image are compared.
const SYMMETRIC_STEPS: usize = 5;

/// Largest difference between a scene and its symmetric image, in units of the observation.
const SYMMETRY_TOLERANCE: f32 = 5e-3;

/// Checks that an environment keeps the contract of [`Env`]; `build` makes equal environments.
///
/// - Its specification is valid ([`EnvSpec::validate`]).
/// - Every number of every observation is written and finite, and so is every position.
/// - An episode depends on its seed and its actions and on nothing else: it is the same, bit for bit,
///   when it is played again, after another episode, and in another environment. Another seed is
///   another episode.
/// - Its symmetries hold, where it can start from a chosen scene ([`Env::reset_to`]): from the image
///   of a scene, the images of the actions lead to the image of what is observed. Steps are compared
///   until an object moves, since contacts need not be solved symmetrically.
///
/// ```
/// use rher_core::testing::check_env;
/// # use rher_core::{Achieved, Desired, Env, EnvError, EnvSpec, Position, Scene, Start};
/// # struct Arm(EnvSpec<1>);
/// # impl Arm {
/// #     fn new() -> Self {
/// #         Self(EnvSpec::new("arm", 1, 1, 5))
/// #     }
/// # }
/// # impl Env<1> for Arm {
/// #     fn spec(&self) -> &EnvSpec<1> {
/// #         &self.0
/// #     }
/// #     fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
/// #         observation[0] = seed as f32;
/// #         let here = Position::new(seed as f32, 0.0, 0.0);
/// #         let achieved = Achieved(Scene::new(here, [here]));
/// #         Ok(Start { achieved, desired: Desired::of_task([here]) })
/// #     }
/// #     fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
/// #         observation[0] = action[0];
/// #         let here = Position::new(action[0], 0.0, 0.0);
/// #         Ok(Achieved(Scene::new(here, [here])))
/// #     }
/// # }
/// let checked = check_env(Arm::new)?;
/// assert_eq!(checked.symmetries, 0);
/// # Ok::<(), rher_core::testing::CheckError>(())
/// ```
///
/// # Errors
///
/// Says what was broken first, in which episode and at which step.
pub fn check_env<const N: usize, E: Env<N>>(build: impl Fn() -> E) -> Result<Checked, CheckError> {
    let mut env = build();
    let spec = env.spec().clone();
    spec.validate()?;
    let mut starts = Vec::new();
    for seed in 0..EPISODES {
        let (start, frames) = play(&mut env, seed)?;
        play(&mut env, seed + EPISODES)?;
        let runs =
            [("played again", play(&mut env, seed)?), ("elsewhere", play(&mut build(), seed)?)];
        for (when, (again, repeated)) in runs {
            let same_start = again == start && frames[0] == repeated[0];
            let differs = frames.iter().zip(&repeated).position(|(a, b)| a != b);
            if let Some(step) = differs.or((!same_start).then_some(0)) {
                return Err(CheckError::NotRepeated { seed, step, when });
            }
        }
        starts.push((start, frames[0].clone()));
    }
    if starts.iter().all(|start| *start == starts[0]) {
        return Err(CheckError::SeedIgnored);
    }
    let symmetries = check_symmetries(&build, &spec)?;
    Ok(Checked { episodes: EPISODES, symmetries })
}

/// What [`check_env`] has checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Checked {
    /// Episodes that were repeated.
    pub episodes: u64,
    /// Mirrors and permutations that were compared with the environment's own physics: none where it
    /// cannot start from a chosen scene.
    pub symmetries: usize,
}

/// An environment breaks the contract of [`Env`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// Its specification is wrong.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// It failed.
    #[error("the environment failed at step {step} of the episode with seed {seed}")]
    Env {
        /// Seed of the episode.
        seed: u64,
        /// Steps taken before.
        step: usize,
        /// What went wrong.
        source: EnvError,
    },
    /// A number was not written, or is not finite.
    #[error(
        "{place} is not a finite number at step {step} of the episode with seed {seed}, or was not \
         written"
    )]
    NotFinite {
        /// Such as `observation[3]`.
        place: String,
        /// Seed of the episode.
        seed: u64,
        /// Steps taken before.
        step: usize,
    },
    /// An episode depends on more than its seed and its actions.
    #[error(
        "the episode with seed {seed} differs from step {step} on when it is {when}; an episode may \
         depend on its seed and its actions only"
    )]
    NotRepeated {
        /// Seed of the episode.
        seed: u64,
        /// The first step that differs.
        step: usize,
        /// `played again`, in the same environment after another episode, or `elsewhere`, in an
        /// equal one.
        when: &'static str,
    },
    /// Every seed starts the same episode.
    #[error("episodes with seeds 0 to {} are all the same; `reset` must use its seed", EPISODES - 1)]
    SeedIgnored,
    /// A symmetry does not hold.
    #[error(
        "{symmetry} does not hold: observation[{index}] is {found} at step {step} of the image of \
         the episode with seed {seed}, expected {expected}"
    )]
    Asymmetric {
        /// Such as `mirrors[0]`.
        symmetry: String,
        /// Seed of the episode.
        seed: u64,
        /// Steps taken before.
        step: usize,
        /// Index in the observation.
        index: usize,
        /// What the environment observed.
        found: f32,
        /// The image of what it observed in the original episode.
        expected: f32,
    },
}

/// What is observed and achieved at each step, as bits.
type Frames = Vec<Vec<u32>>;

/// Plays an episode of random actions that belong to its seed.
fn play<const N: usize>(
    env: &mut impl Env<N>,
    seed: u64,
) -> Result<(Start<N>, Frames), CheckError> {
    let (obs_dim, steps) = (env.spec().obs_dim, env.spec().episode_steps);
    let failed = |step| move |source| CheckError::Env { seed, step, source };
    let mut actions = Actions::new(seed, env.spec().action_dim);
    // What the environment does not write stays NaN.
    let mut observation = vec![f32::NAN; obs_dim];
    let start = env.reset(seed, &mut observation).map_err(failed(0))?;
    let mut frames = vec![frame(&observation, &start.achieved, seed, 0)?];
    for step in 0..steps {
        observation.fill(f32::NAN);
        let achieved = env.step(actions.next(), &mut observation).map_err(failed(step))?;
        let mut now = frame(&observation, &achieved, seed, step + 1)?;
        let end = env.end();
        now.extend(end.map(|end| end as u32));
        frames.push(now);
        if end.is_some() {
            break;
        }
    }
    Ok((start, frames))
}

/// Random actions, each held for a few steps so that something happens.
struct Actions {
    rng: rand_chacha::ChaCha8Rng,
    action: Vec<f32>,
    drawn: usize,
}

impl Actions {
    fn new(seed: u64, action_dim: usize) -> Self {
        let rng = Seed(seed).stream(Purpose::Exploration, 0);
        Self { rng, action: vec![0.0; action_dim], drawn: 0 }
    }

    fn next(&mut self) -> &[f32] {
        if self.drawn.is_multiple_of(5) {
            self.action.fill_with(|| self.rng.random_range(-1.0..=1.0));
        }
        self.drawn += 1;
        &self.action
    }
}

fn frame<const N: usize>(
    observation: &[f32],
    Achieved(scene): &Achieved<N>,
    seed: u64,
    step: usize,
) -> Result<Vec<u32>, CheckError> {
    let not_finite = |place| Err(CheckError::NotFinite { place, seed, step });
    if let Some(index) = observation.iter().position(|number| !number.is_finite()) {
        return not_finite(format!("observation[{index}]"));
    }
    if !scene.is_finite() {
        return not_finite("an achieved position or tail".to_owned());
    }
    let scene = scene.numbers(TAIL_NUMBERS);
    Ok(observation.iter().copied().chain(scene).map(f32::to_bits).collect())
}

/// One symmetry, whatever its kind.
struct Symmetry<'a, const N: usize> {
    name: String,
    position: Box<dyn Fn(Position) -> Position + 'a>,
    order: [usize; N],
    observation: &'a [SignedIndex],
    /// None where actions stay the same.
    action: Option<&'a [SignedIndex]>,
    tail: &'a [SignedIndex],
}

impl<const N: usize> Symmetry<'_, N> {
    fn start(&self, start: &Start<N>) -> Start<N> {
        let places =
            |positions: &[Position; N]| self.order.map(|object| (self.position)(positions[object]));
        let tails = |tails: &Tails<N>| {
            let image = |tail: &_| SignedIndex::image(self.tail, tail);
            tails.reordered(&self.order).map(image)
        };
        let (achieved, desired) = (&start.achieved.0, &start.desired);
        let gripper = (self.position)(achieved.gripper);
        let scene = Scene::new(gripper, places(&achieved.objects));
        let desired_tails = tails(desired.tails());
        Start {
            achieved: Achieved(scene.with_tails(tails(&achieved.tails))),
            desired: Desired::of_task(places(desired.objects())).with_tails(desired_tails),
        }
    }
}

/// Compares every symmetry with the environment's own physics; returns how many could be compared.
fn check_symmetries<const N: usize, E: Env<N>>(
    build: &impl Fn() -> E,
    spec: &EnvSpec<N>,
) -> Result<usize, CheckError> {
    let mirrors = spec.mirrors.iter().enumerate().map(|(index, mirror)| Symmetry {
        name: format!("mirrors[{index}]"),
        position: Box::new(|position| mirror.position(position)),
        order: std::array::from_fn(|object| object),
        observation: &mirror.observation,
        action: Some(&mirror.action),
        tail: &mirror.tail,
    });
    let permutations = spec.permutations.iter().enumerate().map(|(index, permutation)| Symmetry {
        name: format!("permutations[{index}]"),
        position: Box::new(|position| position),
        order: permutation.order,
        observation: &permutation.observation,
        action: None,
        tail: &[],
    });
    let mut compared = 0;
    for symmetry in mirrors.chain(permutations) {
        let mut could_start = false;
        for seed in 0..EPISODES {
            could_start |= compare(&mut build(), &mut build(), &symmetry, seed)?;
        }
        compared += usize::from(could_start);
    }
    Ok(compared)
}

/// Plays an episode and its image; false where the image cannot be started.
fn compare<const N: usize>(
    env: &mut impl Env<N>,
    image: &mut impl Env<N>,
    symmetry: &Symmetry<'_, N>,
    seed: u64,
) -> Result<bool, CheckError> {
    let EnvSpec { obs_dim, action_dim, episode_steps, .. } = *env.spec();
    let mut actions = Actions::new(seed, action_dim);
    let [mut original, mut found, mut expected] = [(); 3].map(|()| vec![0.0; obs_dim]);
    let mut image_action = vec![0.0; action_dim];
    let failed = |step| move |source| CheckError::Env { seed, step, source };
    let start = env.reset(seed, &mut original).map_err(failed(0))?;
    // Both start from a chosen scene, which may differ from that of the seed in what is not chosen.
    let Some(start) = env.reset_to(&start, &mut original).map_err(failed(0))? else {
        return Ok(false);
    };
    let chosen = symmetry.start(&start);
    if image.reset_to(&chosen, &mut found).map_err(failed(0))?.is_none() {
        return Ok(false);
    }
    for step in 0..=SYMMETRIC_STEPS.min(episode_steps) {
        SignedIndex::apply(symmetry.observation, &original, &mut expected);
        let is_off =
            |(found, expected): (&f32, &f32)| (found - expected).abs() > SYMMETRY_TOLERANCE;
        if let Some(index) = found.iter().zip(&expected).position(is_off) {
            return Err(CheckError::Asymmetric {
                symmetry: symmetry.name.clone(),
                seed,
                step,
                index,
                found: found[index],
                expected: expected[index],
            });
        }
        let action = actions.next();
        match symmetry.action {
            Some(entries) => SignedIndex::apply(entries, action, &mut image_action),
            None => image_action.copy_from_slice(action),
        }
        let Achieved(now) = env.step(action, &mut original).map_err(failed(step))?;
        image.step(&image_action, &mut found).map_err(failed(step))?;
        let moves = |object: usize| {
            nalgebra::distance(&now.objects[object], &start.achieved.0.objects[object]) > 1e-4
        };
        if (0..N).any(moves) || env.end().is_some() {
            break;
        }
    }
    Ok(true)
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} episodes repeated, {} symmetries compared", self.episodes, self.symmetries)
    }
}
