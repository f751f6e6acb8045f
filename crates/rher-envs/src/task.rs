//! From a task's name, known at run time, to its environment, known at compile time.

use crate::options::{OptionError, Options, TaskOption};
use crate::simulated::Simulated;
use crate::simulation::{Scenario, Simulation};
use crate::tasks;
use rher_core::Names;
use std::fmt;
use std::str::FromStr;
use std::sync::{PoisonError, RwLock};

/// Work that is written once for every environment type.
pub trait EnvVisitor {
    /// What the work comes to.
    type Output;

    /// Does the work; `build` makes as many environments as it takes.
    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output;
}

/// What makes environments of `N` objects.
type Build<const N: usize> = &'static (dyn Fn(&Options) -> Box<dyn Simulated<N>> + Send + Sync);

/// Makes one type of environment for each number of objects that a task may have.
macro_rules! numbers_of_objects {
    ($($variant:ident = $objects:literal),+) => {
        /// What makes a task's environments, by their number of objects.
        #[derive(Clone, Copy)]
        enum Maker {
            $($variant(Build<$objects>),)+
        }

        impl Maker {
            const fn objects(&self) -> usize {
                match self {
                    $(Self::$variant(_) => $objects,)+
                }
            }

            fn visit<V: EnvVisitor>(self, options: &Options, visitor: V) -> V::Output {
                match self {
                    $(Self::$variant(build) => visitor.visit(|| build(options)),)+
                }
            }
        }

        $(
            impl TaskObjects<$objects> for ObjectCount {
                fn task(build: Build<$objects>, facts: Facts) -> Task {
                    Task(Box::leak(Box::new(Description { facts, maker: Maker::$variant(build) })))
                }
            }
        )+
    };
}

numbers_of_objects! { One = 1, Two = 2, Three = 3, Four = 4, Five = 5, Six = 6 }

/// Implements [`TaskObjects`] for every number of objects that a task may have.
#[derive(Clone, Copy, Debug)]
pub struct ObjectCount;

/// A task may have `N` objects: [`ObjectCount`] implements it for 1 to 6.
pub trait TaskObjects<const N: usize> {
    #[doc(hidden)]
    fn task(build: Build<N>, facts: Facts) -> Task;
}

/// All about a task but its environments.
#[derive(Clone, Copy)]
pub struct Facts {
    name: &'static str,
    about: &'static str,
    gymnasium_id: Option<&'static str>,
    verbs: &'static [&'static str],
    subtasks: usize,
    options: &'static [TaskOption],
    recipe: Option<&'static str>,
    /// Whether its environments can randomize what they simulate.
    randomizes: bool,
}

struct Description {
    facts: Facts,
    maker: Maker,
}

/// A task, known by its name; every copy is the same task.
#[derive(Clone, Copy)]
pub struct Task(&'static Description);

/// The list of tasks: constant, scenario, number of objects, Gymnasium's name.
macro_rules! tasks {
    ($(#[doc = $about:literal] $task:ident: $scenario:ty, $maker:ident = $objects:literal, $id:literal;)+) => {
        impl Task {
            $(
                #[doc = $about]
                pub const $task: Self = Self(&Description {
                    facts: facts::<$scenario, $objects>($about, Some(concat!("rher/", $id, "-v0"))),
                    maker: Maker::$maker(&simulation::<$scenario, $objects>),
                });
            )+

            /// The tasks of this crate, the simplest first.
            pub const ALL: &[Self] = &[$(Self::$task),+];
        }
    };
}

tasks! {
    /// Bring the gripper to a place in the air.
    REACH: tasks::Reach, One = 1, "Reach";
    /// Push a block to a place on the table.
    PUSH: tasks::Push, One = 1, "Push";
    /// Bring a block to a place on the table or above it.
    PICK: tasks::Pick, One = 1, "PickAndPlace";
    /// Hit a puck so that it slides to a place beyond reach.
    SLIDE: tasks::Slide, One = 1, "Slide";
    /// Bring the gripper into a hole.
    INSERT: tasks::Insert, One = 1, "Insert";
    /// Push a block to a place on the table, round an obstacle.
    OBSTACLE_PUSH: tasks::ObstaclePush, One = 1, "ObstaclePush";
    /// Pull a drawer open by its handle.
    DRAWER: tasks::Drawer, One = 1, "Drawer";
    /// Push a cylinder to a place on the table with a cue.
    CUE_PUSH: tasks::CuePush, One = 1, "CuePush";
    /// Push two blocks, each to its place on the table.
    DPUSH: tasks::DPush, Two = 2, "DPush";
    /// Bring a block to a place on the table, and another on top of it.
    STACK: tasks::Stack, Two = 2, "Stack";
    /// Pull a drawer open, take a block out of it and put it on top of the cabinet.
    DRAWER_BOX: tasks::DrawerBox, Two = 2, "DrawerBox";
    /// Push three blocks, each to its place on the table.
    TPUSH: tasks::TPush, Three = 3, "TPush";
    /// Bring a block to a place on the table, and two more on top of it.
    TSTACK: tasks::TStack, Three = 3, "TStack";
}

const fn facts<S: Scenario<N>, const N: usize>(
    about: &'static str,
    gymnasium_id: Option<&'static str>,
) -> Facts {
    Facts {
        name: S::NAME,
        about,
        gymnasium_id,
        verbs: &S::VERBS,
        subtasks: S::SUBTASKS,
        options: S::OPTIONS,
        recipe: S::RECIPE,
        randomizes: true,
    }
}

fn simulation<S: Scenario<N>, const N: usize>(options: &Options) -> Box<dyn Simulated<N>> {
    Box::new(Simulation::<S, N>::built(options))
}

/// The tasks that a program added to those of this crate.
static ADDED: RwLock<Vec<Task>> = RwLock::new(Vec::new());

/// What is said of a task that says nothing of itself.
const ADDED_HERE: &str = "A task of this program.";

impl Task {
    /// Adds the task that `S` describes to those that this process knows by name.
    ///
    /// # Errors
    ///
    /// If its name is taken, or cannot be the name of a folder.
    pub fn add_scenario<S: Scenario<N>, const N: usize>() -> Result<Self, TaskNameError>
    where
        ObjectCount: TaskObjects<N>,
    {
        let facts = facts::<S, N>(ADDED_HERE, None);
        ObjectCount::task(&simulation::<S, N>, facts).add()
    }

    /// Adds a task whose environments `build` makes to those that this process knows by name; its
    /// name is that of their specification.
    ///
    /// # Errors
    ///
    /// If its name is taken, or cannot be the name of a folder.
    pub fn add_env<E: Simulated<N>, const N: usize>(
        build: impl Fn() -> E + Send + Sync + 'static,
    ) -> Result<Self, TaskNameError>
    where
        ObjectCount: TaskObjects<N>,
    {
        let spec = build().spec().clone();
        let facts = Facts {
            name: spec.name.leak(),
            about: ADDED_HERE,
            gymnasium_id: None,
            verbs: &["place"; N],
            subtasks: spec.subtasks,
            options: &[],
            recipe: None,
            randomizes: false,
        };
        let build = move |_: &Options| -> Box<dyn Simulated<N>> { Box::new(build()) };
        ObjectCount::task(Box::leak(Box::new(build)), facts).add()
    }

    fn add(self) -> Result<Self, TaskNameError> {
        let name = self.name().to_owned();
        let is_letter = |letter: char| matches!(letter, 'a'..='z' | '0'..='9' | '-' | '_');
        if name.is_empty() || !name.chars().all(is_letter) {
            return Err(TaskNameError::Letters { name });
        }
        let mut added = ADDED.write().unwrap_or_else(PoisonError::into_inner);
        if Self::ALL.iter().chain(&*added).any(|task| task.name() == name) {
            return Err(TaskNameError::Taken { name });
        }
        added.push(self);
        Ok(self)
    }

    /// Every task that this process knows: those of this crate, then those that were added.
    pub fn all() -> Vec<Self> {
        let added = ADDED.read().unwrap_or_else(PoisonError::into_inner);
        [Self::ALL, &added].concat()
    }

    /// Name on the command line and in files.
    pub const fn name(self) -> &'static str {
        self.0.facts.name
    }

    /// What there is to do, in a sentence.
    pub fn about(self) -> &'static str {
        self.0.facts.about.trim()
    }

    /// Number of objects, N.
    pub const fn objects(self) -> usize {
        self.0.maker.objects()
    }

    /// Settings that this task has and no other.
    pub const fn options(self) -> &'static [TaskOption] {
        self.0.facts.options
    }

    /// Settings with which the preset `fast` is better for this task, as TOML.
    pub const fn recipe(self) -> Option<&'static str> {
        self.0.facts.recipe
    }

    /// The identity of this task's Gymnasium environment, where the Python package has one.
    pub const fn gymnasium_id(self) -> Option<&'static str> {
        self.0.facts.gymnasium_id
    }

    /// What its sub-tasks are called: `reach` and `push`, or `reach 1`, `push 1`, `reach 2` and so
    /// on.
    pub fn subtasks(self) -> Vec<String> {
        subtasks(self.0.facts.verbs, self.0.facts.subtasks)
    }

    /// What the numbers of this task's observations and actions are, under these options.
    pub fn names(self, options: &Options) -> Result<Names, OptionError> {
        self.visit_with(options, NamesOf)
    }

    /// Hands the environment of this task to `visitor`.
    pub fn visit<V: EnvVisitor>(self, visitor: V) -> V::Output {
        self.0.maker.visit(&Options::of(self.options()), visitor)
    }

    /// Hands the environment of this task, under these options, to `visitor`.
    pub fn visit_with<V: EnvVisitor>(
        self,
        options: &Options,
        visitor: V,
    ) -> Result<V::Output, OptionError> {
        if !self.0.facts.randomizes {
            options.randomize.check_unset()?;
        }
        Ok(self.0.maker.visit(&options.check(self.options())?, visitor))
    }
}

/// A task cannot be added to those that are known by name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TaskNameError {
    /// There is one of this name.
    #[error("there is a task called `{name}` already; give yours another name")]
    Taken {
        /// The name.
        name: String,
    },
    /// Names of tasks are names of folders and words of a command line.
    #[error("`{name}` cannot be the name of a task: expected a to z, 0 to 9, `-` and `_`")]
    Letters {
        /// The name.
        name: String,
    },
}

impl PartialEq for Task {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Task {}

impl fmt::Debug for Task {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Task({})", self.name())
    }
}

/// The first `count` of reaching and placing each object in turn.
fn subtasks(verbs: &[&str], count: usize) -> Vec<String> {
    let stages = verbs.iter().enumerate().flat_map(|(object, verb)| {
        let name = |stage: &str| match verbs.len() {
            1 => stage.to_owned(),
            _ => format!("{stage} {}", object + 1),
        };
        [name("reach"), name(verb)]
    });
    stages.take(count).collect()
}

/// Asks an environment for its names.
struct NamesOf;

impl EnvVisitor for NamesOf {
    type Output = Names;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Names {
        build().spec().names.clone()
    }
}

impl fmt::Display for Task {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Task {
    type Err = UnknownTask;

    fn from_str(name: &str) -> Result<Self, UnknownTask> {
        let known = Self::all().into_iter().find(|task| task.name() == name);
        known.ok_or_else(|| UnknownTask { name: name.to_owned() })
    }
}

/// No task has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no task is called `{name}`; there are {}", known_names())]
pub struct UnknownTask {
    /// What was asked for.
    pub name: String,
}

fn known_names() -> String {
    Task::all().iter().map(|task| task.name()).collect::<Vec<_>>().join(", ")
}
