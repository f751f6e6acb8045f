//! Relay Hindsight Experience Replay for environments of your own.
//!
//! A task with `N` objects is cut into `2 N` stages (reach an object, move it, reach the next),
//! and one network learns the `2 N` sub-tasks that end with each of them.
//!
//! Data flows through the modules in this order: [`goal`] and [`mod@env`] say what is asked and
//! what happens, [`explore`] who acts, [`episode`] and [`replay`] keep what happened, [`relabel`]
//! replays it for every sub-task as [`input`] to the networks, in a [`batch`], and [`learner`]
//! learns from it; `train` is the loop around them.
//!
//! ```
//! use rher_core::goal::{Achieved, Desired, EncodedGoal, Position, Scene, Stage, Tolerances};
//!
//! let block = Position::new(0.3, 0.1, 0.0);
//! let now = Achieved(Scene { gripper: Position::origin(), objects: [block] });
//! let desired = Desired::of_task([Position::new(0.4, 0.1, 0.0)]);
//! let tolerances = Tolerances::uniform(0.05);
//!
//! // The hand is far from the block, so the relay is at its first stage: reach it.
//! let stage = Stage::of(&now, &desired, &tolerances, 0.03);
//! assert_eq!(stage, Stage::FIRST);
//!
//! // That sub-task sees the block's place as the hand's goal, and a blank for the block.
//! let goal = EncodedGoal::new(stage, &now, &desired);
//! assert_eq!(goal.gripper(), Some(block));
//! assert_eq!(goal.objects(), &[None]);
//! assert_eq!(goal.reward(&now, &tolerances), -1.0);
//! ```

#[doc(hidden)]
pub mod batch;
pub mod config;
pub mod env;
pub mod episode;
#[cfg(feature = "train")]
pub mod evaluate;
pub mod event;
#[doc(hidden)]
pub mod explore;
pub mod files;
pub mod goal;
#[doc(hidden)]
pub mod input;
#[doc(hidden)]
pub mod learner;
pub mod policy;
#[doc(hidden)]
pub mod relabel;
#[doc(hidden)]
pub mod replay;
#[doc(hidden)]
pub mod seed;
mod symmetry;
pub mod testing;
#[cfg(feature = "train")]
pub mod train;

pub use config::{ConfigError, Preset, TrainConfig};
pub use env::{Env, EnvError, EnvSpec, Mirror, Permutation, SignedIndex, SpecError, Start};
pub use episode::{ActError, Episode, RolloutError, View, rollout};
#[cfg(feature = "train")]
pub use evaluate::{Evaluation, evaluate};
pub use event::{Event, Metrics, Observer, ObserverError};
pub use goal::{Achieved, Desired, EncodedGoal, Leg, Position, Scene, Stage, Tolerances};
pub use policy::{Actor, Mismatch, Policy, PolicyError, PolicyInfo};
#[cfg(feature = "train")]
pub use train::{Finish, TrainError, Trainer};

/// The crate whose points are [`Position`]s.
pub use nalgebra;

/// The code of the tour is compiled and run.
#[cfg(all(doctest, feature = "fused"))]
#[doc = include_str!("../../../docs/tour.md")]
struct Tour;
