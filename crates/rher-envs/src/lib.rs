//! The tasks of Relay Hindsight Experience Replay on the Rapier physics engine.
//!
//! Tasks with one object follow the Fetch environments of Gymnasium-Robotics number by number, so
//! that a policy trained here runs there, and the other way round.
//!
//! ```
//! use rher_core::env::Env as _;
//! use rher_envs::{Simulation, tasks::Push};
//!
//! let mut env = Simulation::<Push, 1>::new();
//! let mut observation = vec![0.0; env.spec().obs_dim];
//! let start = env.reset(7, &mut observation)?;
//! let achieved = env.step(&[1.0, 0.0, 0.0, 0.0], &mut observation)?;
//! assert!(achieved.0.gripper.x > start.achieved.0.gripper.x);
//! # Ok::<(), rher_core::env::EnvError>(())
//! ```

/// The worked example is compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/adding-a-task.md")]
struct AddingATask;

mod goals;
mod layout;
mod observation;
mod options;
mod pool;
pub mod render;
mod sim;
mod simulated;
mod simulation;
mod task;
pub mod tasks;
pub mod thing;
mod threads;

pub use goals::{RewardKind, achieved_goal};
pub use layout::{Chosen, ChosenError, Layout};
pub use observation::{Places, Sink, Subject, gripper_and_object};
pub use options::{
    OptionError, OptionValue, Options, Randomize, RandomizeSetting, TaskOption, TaskOptions,
};
pub use pool::{AutoReset, Frames, Pool, PoolError, PoolRecord};
pub use sim::{
    Body, DETECTIONS_AND_SOLVER_SUBSTEPS as SUBSTEPS, Fingers, Grip, Motion, RAPIER_VERSION,
    STEP_SECONDS, Scenery, World,
};
pub use simulated::{Simulated, Snapshot, SnapshotError};
pub use simulation::{ACTION_WIDTH, Scenario, Simulation};
pub use task::{EnvVisitor, ObjectCount, Task, TaskNameError, TaskObjects, UnknownTask};
