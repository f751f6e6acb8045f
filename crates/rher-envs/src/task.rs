//! From a task's name, known at run time, to its environment, known at compile time.

use crate::options::{OptionError, Options, TaskOption};
use crate::simulation::{Simulated, Simulation};
use crate::tasks;
use rher_core::Names;
use std::fmt;
use std::str::FromStr;

/// Work that is written once for every environment type.
pub trait EnvVisitor {
    /// What the work comes to.
    type Output;

    /// Does the work; `build` makes as many environments as it takes.
    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output;
}

/// The list of tasks: variant, scenario, objects.
macro_rules! tasks {
    ($($(#[$doc:meta])* $task:ident: $scenario:ty, $objects:literal;)+) => {
        /// The tasks, by name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Task {
            $($(#[$doc])* $task,)+
        }

        impl Task {
            /// Every task, the simplest first.
            pub const ALL: &[Self] = &[$(Self::$task),+];

            /// Name on the command line and in files.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$task => <$scenario as crate::simulation::Scenario<$objects>>::NAME,)+
                }
            }

            /// Hands the environment of this task to `visitor`.
            pub fn visit<V: EnvVisitor>(self, visitor: V) -> V::Output {
                match self {
                    $(Self::$task => visitor.visit(Simulation::<$scenario, $objects>::new),)+
                }
            }

            /// Hands the environment of this task, under these options, to `visitor`.
            pub fn visit_with<V: EnvVisitor>(
                self,
                options: &Options,
                visitor: V,
            ) -> Result<V::Output, OptionError> {
                let options = options.check(self.options())?;
                Ok(match self {
                    $(Self::$task => {
                        visitor.visit(|| Simulation::<$scenario, $objects>::built(&options))
                    })+
                })
            }

            /// Number of objects, N.
            pub const fn objects(self) -> usize {
                match self {
                    $(Self::$task => $objects,)+
                }
            }

            /// What its sub-tasks are called: `reach` and `push`, or `reach 1`, `push 1`, `reach 2`
            /// and so on.
            pub fn subtasks(self) -> Vec<String> {
                match self {
                    $(Self::$task => {
                        subtasks(
                            &<$scenario as crate::simulation::Scenario<$objects>>::VERBS,
                            <$scenario as crate::simulation::Scenario<$objects>>::SUBTASKS,
                        )
                    })+
                }
            }

            /// Settings that this task has and no other.
            pub const fn options(self) -> &'static [TaskOption] {
                match self {
                    $(Self::$task => <$scenario as crate::simulation::Scenario<$objects>>::OPTIONS,)+
                }
            }

            /// Settings with which the preset `fast` is better for this task, as TOML.
            pub const fn recipe(self) -> Option<&'static str> {
                match self {
                    $(Self::$task => <$scenario as crate::simulation::Scenario<$objects>>::RECIPE,)+
                }
            }
        }
    };
}

tasks! {
    /// Bring the gripper to a place in the air.
    Reach: tasks::Reach, 1;
    /// Push a block to a place on the table.
    Push: tasks::Push, 1;
    /// Bring a block to a place on the table or above it.
    Pick: tasks::Pick, 1;
    /// Hit a puck so that it slides to a place beyond reach.
    Slide: tasks::Slide, 1;
    /// Bring the gripper into a hole.
    Insert: tasks::Insert, 1;
    /// Push a block to a place on the table, round an obstacle.
    ObstaclePush: tasks::ObstaclePush, 1;
    /// Pull a drawer open by its handle.
    Drawer: tasks::Drawer, 1;
    /// Push a cylinder to a place on the table with a cue.
    CuePush: tasks::CuePush, 1;
    /// Push two blocks, each to its place on the table.
    DPush: tasks::DPush, 2;
    /// Bring a block to a place on the table, and another on top of it.
    Stack: tasks::Stack, 2;
    /// Pull a drawer open, take a block out of it and put it on top of the cabinet.
    DrawerBox: tasks::DrawerBox, 2;
    /// Push three blocks, each to its place on the table.
    TPush: tasks::TPush, 3;
    /// Bring a block to a place on the table, and two more on top of it.
    TStack: tasks::TStack, 3;
}

impl Task {
    /// What the numbers of this task's observations and actions are, under these options.
    pub fn names(self, options: &Options) -> Result<Names, OptionError> {
        self.visit_with(options, NamesOf)
    }

    /// The identity of this task's Gymnasium environment in the Python package.
    pub fn gymnasium_id(self) -> String {
        match self {
            Self::Pick => "rher/PickAndPlace-v0".to_owned(),
            task => format!("rher/{task:?}-v0"),
        }
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
        let known = Self::ALL.iter().find(|task| task.name() == name);
        known.copied().ok_or_else(|| UnknownTask { name: name.to_owned() })
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
    Task::ALL.iter().map(|task| task.name()).collect::<Vec<_>>().join(", ")
}
