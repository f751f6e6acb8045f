//! From a [`Scenario`] to an environment.

use crate::layout::{Chosen, Layout};
use crate::observation::{Labels, Numbers, Owners, Places, Positions, Reflections, Sink};
use crate::options::{OptionError, Options, Randomize, TaskOption, TaskOptions};
use crate::sim::{self, Fingers, STEP_SECONDS, World};
use crate::simulated::{Simulated, Snapshot, SnapshotError};
use crate::thing::Thing;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::env::{Env, EnvError, EnvSpec, Mirror, SignedIndex, Start};
use rher_core::goal::{Achieved, Desired, Position, Scene, Tolerances};
use rher_core::{Control, Names};
use std::iter;
use std::marker::PhantomData;

/// Numbers in an action of a hand with fingers: its displacement along x, y and z, then their
/// opening.
pub const ACTION_WIDTH: usize = 4;

/// The plane y = 0.7491 m through the Fetch robot and its table.
pub(crate) const MIDDLE: f32 = 0.7491;

/// The frame of all positions.
const FRAME: &str = "that of Gymnasium-Robotics' Fetch tasks: right-handed, x forward from the \
                     robot to the table, y to the robot's left, z up from the floor";

/// What makes one task differ from another.
pub trait Scenario<const N: usize>: Sized + Send + 'static {
    /// Name of the task.
    const NAME: &'static str;

    /// What kind of thing each object is, in relay order.
    const OBJECTS: [&'static str; N] = ["block"; N];

    /// What bringing each object to its place is called, in a word.
    const VERBS: [&'static str; N] = ["place"; N];

    /// Numbers in an action: the first of those of a hand with fingers, the others being 0.
    const ACTION_WIDTH: usize = ACTION_WIDTH;

    /// Steps of every episode.
    const EPISODE_STEPS: usize = 50;

    /// How many sub-tasks there are to learn.
    const SUBTASKS: usize = 2 * N;

    /// How near an object counts as at its target, in meters.
    const TOLERANCE: f32 = 0.05;

    /// How near the gripper counts as at an object, in meters.
    const REACH_TOLERANCE: f32 = Self::TOLERANCE;

    /// Whether nothing but their order tells the objects apart, so that a replay may exchange them
    /// and networks see them in order of turn. [`Sink::about`] then has to say which numbers of an
    /// observation are about which object.
    const ALIKE: bool = false;

    /// Whether objects that are alike may be placed in every order.
    const ANY_ORDER: bool = false;

    /// Whether the scene in front of the hand, as an episode begins, is like that behind it, but for
    /// an arm that is stretched in one and folded in the other.
    const FRONT_LIKE_BACK: bool = false;

    /// Settings that this task has and no other.
    const OPTIONS: &'static [TaskOption] = &[];

    /// Settings with which the preset `fast` reaches the success rate on this task sooner, or with
    /// a better budget, as TOML.
    const RECIPE: Option<&'static str> = None;

    /// Sets the scene.
    fn build() -> (Self, World);

    /// Changes the scene to what is set.
    fn configure(&mut self, _options: &TaskOptions, _world: &mut World) {}

    /// Draws the beginning of an episode.
    fn draw(rng: &mut ChaCha8Rng) -> Layout<N>;

    /// Puts the objects of a fresh world in their places.
    fn place(&self, layout: &Layout<N>, world: &mut World);

    /// Where the gripper is now, as observations and goals have it.
    fn gripper(&self, world: &World) -> Position {
        world.grip().position
    }

    /// Where the objects are now.
    fn objects(&self, layout: &Layout<N>, world: &World) -> [Position; N];

    /// Says what the agent sees.
    fn observe(&self, layout: &Layout<N>, world: &World, out: &mut impl Sink);
}

/// A [`Scenario`] in a world of its own.
pub struct Simulation<S, const N: usize> {
    spec: EnvSpec<N>,
    options: Options,
    scenario: S,
    world: World,
    layout: Layout<N>,
}

/// The state of a [`Simulation`]; that of another scenario is another type.
struct State<S, const N: usize> {
    world: sim::State,
    layout: Layout<N>,
    options: Options,
    scenario: PhantomData<fn() -> S>,
}

impl<S: Scenario<N>, const N: usize> Simulation<S, N> {
    /// Sets the scene, every option at its default.
    ///
    /// # Panics
    ///
    /// If the scenario's objects are [alike](Scenario::ALIKE) and its observation does not say
    /// [which numbers are about which object](Sink::about).
    #[must_use]
    pub fn new() -> Self {
        Self::built(&Options::of(S::OPTIONS))
    }

    /// Sets the scene as `options` have it.
    pub fn with(options: &Options) -> Result<Self, OptionError> {
        Ok(Self::built(&options.check(S::OPTIONS)?))
    }

    /// Sets the scene as `options` have it, which fit: as if episode 0 had been reset.
    pub(crate) fn built(options: &Options) -> Self {
        let (mut scenario, mut world) = S::build();
        scenario.configure(&options.task, &mut world);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let layout = S::draw(&mut rng);
        begin(&scenario, &layout, &options.randomize, rng, &mut world);

        let mirror = |axis, center| {
            let mut reflections = Reflections::new(axis, center);
            scenario.observe(&layout, &world, &mut reflections);
            let (observation, action) =
                (reflections.into_vec(), mirrored_action(axis, S::ACTION_WIDTH));
            Mirror { axis, center, observation, action, tail: Vec::new() }
        };
        let behind = S::FRONT_LIKE_BACK.then(|| mirror(0, world.grip().position.x));
        let mirrors: Vec<_> = iter::once(mirror(1, MIDDLE)).chain(behind).collect();
        let permutations = if S::ALIKE {
            let mut owners = Owners::new();
            scenario.observe(&layout, &world, &mut owners);
            owners.permutations().unwrap_or_else(|error| panic!("task `{}`: {error}", S::NAME))
        } else {
            Vec::new()
        };
        let objects: Vec<String> = S::OBJECTS
            .iter()
            .enumerate()
            .map(|(index, kind)| format!("{kind}{}", index + 1))
            .collect();
        let mut labels = Labels::new(&objects);
        scenario.observe(&layout, &world, &mut labels);
        let units = labels.units();
        let observation = labels.into_names();
        let action = action_names(world.fingers(), S::ACTION_WIDTH);
        let control = Control {
            rate_hz: Some(1.0 / STEP_SECONDS),
            frame: FRAME.to_owned(),
            observation_units: units,
            action_units: action_units(&world, S::ACTION_WIDTH),
        };
        let names = Names { objects, observation, action, tail: Vec::new() };
        let spec = EnvSpec {
            name: S::NAME.to_owned(),
            variant: options.to_string(),
            obs_dim: mirrors[0].observation.len(),
            action_dim: S::ACTION_WIDTH,
            episode_steps: S::EPISODE_STEPS,
            subtasks: S::SUBTASKS,
            tolerances: Tolerances {
                gripper: S::REACH_TOLERANCE,
                ..Tolerances::uniform(S::TOLERANCE)
            },
            mirrors,
            permutations,
            any_order: S::ANY_ORDER,
            names,
            control,
        };
        Self { spec, options: options.clone(), scenario, world, layout }
    }

    /// Starts an episode from `layout`, with all else drawn from `rng`.
    fn start(
        &mut self,
        layout: Layout<N>,
        rng: ChaCha8Rng,
        observation: &mut [f32],
    ) -> Result<Start<N>, EnvError> {
        self.layout = layout;
        self.world.reset();
        begin(&self.scenario, &layout, &self.options.randomize, rng, &mut self.world);
        let achieved = self.observe(observation)?;
        Ok(Start { achieved, desired: Desired::of_task(layout.targets) })
    }

    fn observe(&self, observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        check_width("observation", self.spec.obs_dim, observation.len())?;
        self.scenario.observe(&self.layout, &self.world, &mut Numbers::new(observation));
        Ok(achieved(&self.scenario, &self.layout, &self.world))
    }
}

fn achieved<S: Scenario<N>, const N: usize>(
    scenario: &S,
    layout: &Layout<N>,
    world: &World,
) -> Achieved<N> {
    Achieved(Scene::new(scenario.gripper(world), scenario.objects(layout, world)))
}

/// Makes an episode of a fresh world.
fn begin<S: Scenario<N>, const N: usize>(
    scenario: &S,
    layout: &Layout<N>,
    randomize: &Randomize,
    mut rng: ChaCha8Rng,
    world: &mut World,
) {
    world.vary(randomize, &mut rng);
    scenario.place(layout, world);
    world.open_eyes(randomize, rng);
}

impl<S: Scenario<N>, const N: usize> Default for Simulation<S, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scenario<N>, const N: usize> Env<N> for Simulation<S, N> {
    fn spec(&self) -> &EnvSpec<N> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<N>, EnvError> {
        self.reset_with(seed, &Chosen::default(), observation)
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<N>, EnvError> {
        self.world.step(checked_action(action, S::ACTION_WIDTH)?);
        self.observe(observation)
    }

    fn reset_to(
        &mut self,
        start: &Start<N>,
        observation: &mut [f32],
    ) -> Result<Option<Start<N>>, EnvError> {
        let layout = Layout::new(start.achieved.0.objects, *start.desired.objects());
        self.arrange(layout, observation).map(Some)
    }

    fn truth(&mut self) -> Option<Achieved<N>> {
        let Self { scenario, layout, world, .. } = self;
        world.bare(|world| achieved(scenario, layout, world))
    }
}

impl<S: Scenario<N>, const N: usize> Simulated<N> for Simulation<S, N> {
    fn arrange(
        &mut self,
        layout: Layout<N>,
        observation: &mut [f32],
    ) -> Result<Start<N>, EnvError> {
        self.start(layout, ChaCha8Rng::seed_from_u64(0), observation)
    }

    fn reset_with(
        &mut self,
        seed: u64,
        chosen: &Chosen,
        observation: &mut [f32],
    ) -> Result<Start<N>, EnvError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let layout = chosen.of(S::draw(&mut rng)).map_err(EnvError::new)?;
        let start = self.start(layout, rng, observation)?;
        if chosen.objects.is_some() {
            let Achieved(Scene { objects, .. }) = self.truth().unwrap_or(start.achieved);
            chosen.check(&objects).map_err(EnvError::new)?;
        }
        Ok(start)
    }

    fn snapshot(&self) -> Option<Snapshot> {
        Some(Snapshot::new(State::<S, N> {
            world: self.world.state().clone(),
            layout: self.layout,
            options: self.options.clone(),
            scenario: PhantomData,
        }))
    }

    fn return_to(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let state: &State<S, N> = snapshot.get().ok_or(SnapshotError::OtherTask)?;
        if state.options != self.options {
            let (expected, found) = (self.options.clone(), state.options.clone());
            return Err(SnapshotError::OtherOptions {
                expected: Box::new(expected),
                found: Box::new(found),
            });
        }
        self.world.restore(&state.world);
        self.layout = state.layout;
        Ok(())
    }

    fn options(&self) -> &Options {
        &self.options
    }

    fn places(&self) -> Places<N> {
        let mut positions = Positions::new();
        self.scenario.observe(&self.layout, &self.world, &mut positions);
        positions.into_places()
    }

    fn can_reach(&self, place: &Position) -> bool {
        let grip = self.world.grip().position;
        let place = place - (self.scenario.gripper(&self.world) - grip);
        self.world.can_reach(&place, S::REACH_TOLERANCE)
    }

    fn things(&self) -> Vec<Thing> {
        self.world.things()
    }
}

/// An action or a buffer does not fit.
#[derive(Debug, thiserror::Error)]
enum InputError {
    #[error("{what} has {got} numbers, expected {expected}")]
    Width { what: &'static str, expected: usize, got: usize },
    #[error("number {index} of the action is {value}")]
    NotFinite { index: usize, value: f32 },
}

/// Every number within [−1, 1].
fn checked_action(action: &[f32], width: usize) -> Result<[f32; ACTION_WIDTH], EnvError> {
    check_width("action", width, action.len())?;
    let mut checked = [0.0; ACTION_WIDTH];
    for (index, (out, &value)) in checked.iter_mut().zip(action).enumerate() {
        if value.is_nan() {
            return Err(EnvError::new(InputError::NotFinite { index, value }));
        }
        *out = value.clamp(-1.0, 1.0);
    }
    Ok(checked)
}

fn check_width(what: &'static str, expected: usize, got: usize) -> Result<(), EnvError> {
    if expected == got {
        Ok(())
    } else {
        Err(EnvError::new(InputError::Width { what, expected, got }))
    }
}

fn action_names(fingers: Fingers, width: usize) -> Vec<String> {
    let hand = match fingers {
        Fingers::Locked => "locked_fingers",
        Fingers::Free => "fingers",
        Fingers::Cue => "cue",
    };
    let names = ["x", "y", "z", "opening"].map(|what| format!("{hand}.{what}"));
    names.into_iter().take(width).collect()
}

fn action_units(world: &World, width: usize) -> Vec<String> {
    let shift = format!("{} m/step", world.hand_step());
    let opening = match world.fingers() {
        Fingers::Free => "1 m/step",
        Fingers::Locked | Fingers::Cue => "nothing",
    };
    let units = [shift.clone(), shift.clone(), shift, opening.to_owned()];
    units.into_iter().take(width).collect()
}

fn mirrored_action(axis: usize, width: usize) -> Vec<SignedIndex> {
    let sign = |from| if from == axis { -1.0 } else { 1.0 };
    (0..width).map(|from| SignedIndex { from, sign: sign(from), offset: 0.0 }).collect()
}
