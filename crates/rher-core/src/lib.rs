//! Relay Hindsight Experience Replay: trains policies for object manipulation from sparse rewards,
//! on your own environments, and deploys them beside your robot.
//!
//! A task with `N` objects is cut into `2 N` stages: reach an object, place it, reach the next one.
//! One goal-conditioned network learns the `2 N` sub-tasks that end with these stages. A sub-task
//! that is already learned guides exploration to where the next one can be learned, and every
//! episode is replayed, in hindsight, for every sub-task.
//!
//! The crate contains the method and nothing else: it needs no simulator, no command line and no
//! Python. The simulated tasks are in `rher-envs`, the program `rher` is in `rher-cli`.
//!
//! - [Train on your environment](#train-on-your-environment)
//! - [Check your environment](#check-your-environment)
//! - [Act with a policy](#act-with-a-policy)
//! - [Goals and rewards](#goals-and-rewards)
//! - [Reproducibility](#reproducibility)
//! - [Features](#features)
//!
//! # Train on your environment
//!
//! Implement [`Env`] for your scene: what the agent observes, where the gripper and the objects
//! are, and where the objects should be. There is no reward to write, since the reward is a
//! function of these positions. Start from the settings of a [`Preset`] and hand both to a
//! [`Trainer`].
//!
#![cfg_attr(feature = "fused", doc = "```")]
#![cfg_attr(not(feature = "fused"), doc = "```ignore")]
//! use rand::{RngExt as _, SeedableRng as _};
//! use rher_core::{
//!     Achieved, Desired, Env, EnvError, EnvSpec, Event, Position, Preset, Scene, Start, Trainer,
//! };
//! use std::sync::atomic::AtomicBool;
//!
//! /// A hand on a line that carries the block that it touches.
//! struct Line {
//!     spec: EnvSpec<1>,
//!     scene: Scene<1>,
//! }
//!
//! impl Line {
//!     fn new() -> Self {
//!         // An observation has one number, an action one, an episode 20 steps.
//!         let spec = EnvSpec::new("line", 1, 1, 20);
//!         Self { spec, scene: Scene::new(Position::origin(), [Position::origin()]) }
//!     }
//!
//!     fn observe(&self, observation: &mut [f32]) -> Achieved<1> {
//!         observation[0] = self.scene.gripper.x - self.scene.objects[0].x;
//!         Achieved(self.scene)
//!     }
//! }
//!
//! impl Env<1> for Line {
//!     fn spec(&self) -> &EnvSpec<1> {
//!         &self.spec
//!     }
//!
//!     // An episode depends on its seed and its actions, and on nothing else.
//!     fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
//!         let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
//!         let mut anywhere = || Position::new(rng.random(), 0.0, 0.0);
//!         self.scene = Scene::new(anywhere(), [anywhere()]);
//!         let desired = Desired::of_task([anywhere()]);
//!         Ok(Start { achieved: self.observe(observation), desired })
//!     }
//!
//!     fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
//!         let touched = (self.scene.gripper.x - self.scene.objects[0].x).abs() < 0.05;
//!         self.scene.gripper.x += 0.1 * action[0];
//!         if touched {
//!             self.scene.objects[0] = self.scene.gripper;
//!         }
//!         Ok(self.observe(observation))
//!     }
//! }
//!
//! let mut config = Preset::Fast.config("line", 1);
//! config.env_steps = 400; // enough for an example, not for a good policy
//! config.agent.hidden = vec![16];
//! config.evaluation.every_episodes = 10;
//! let mut trainer = Trainer::new(config, vec![Line::new()], 1)?;
//! let mut print = |event: &Event| {
//!     if let Event::Evaluated(metrics) = event {
//!         println!("{} steps: success {:?}", metrics.env_steps, metrics.success);
//!     }
//!     Ok(())
//! };
//! trainer.run(None, &mut print, &AtomicBool::new(false))?;
//!
//! // The policy is one file, which needs neither the environment nor the trainer.
//! let folder = tempfile::tempdir()?;
//! trainer.policy().save(&folder.path().join("line.safetensors"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! With a folder in place of `None`, [`Trainer::run`] writes checkpoints there, from which
//! [`Trainer::resume`] continues the run; [`Trainer::new_from`] starts another one with what it has
//! learned. `examples/custom_env.rs` is a complete program.
//!
//! # Check your environment
//!
//! [`testing::check_env`] checks in one call that an environment keeps its contract: its
//! specification is valid, its numbers are finite, its episodes repeat bit for bit, and its
//! symmetries hold. [`EnvSpec::validate`] checks a specification alone; a [`Trainer`] calls it,
//! too.
//!
//! ```
//! use rher_core::EnvSpec;
//!
//! let mut spec = EnvSpec::<2>::new("two-blocks", 43, 4, 60);
//! assert!(spec.validate().is_ok());
//! spec.subtasks = 5; // two objects have four sub-tasks
//! assert!(spec.validate().is_err());
//! ```
//!
//! # Act with a policy
//!
//! [`Policy::load`] reads a policy file; [`Policy::actor`] checks once that the policy fits your
//! robot, and [`Actor::act`] computes an action without allocating memory. It refuses lengths that
//! are wrong and numbers that are not finite, so a broken sensor does not move the arm.
//!
//! ```no_run
//! use rher_core::{Achieved, Desired, EnvSpec, Policy, Position, Scene};
//! # fn read_robot(observation: &mut [f32]) -> Scene<1> {
//! #     observation.fill(0.0);
//! #     Scene::new(Position::origin(), [Position::origin()])
//! # }
//! # fn move_robot(_: &[f32]) {}
//!
//! let policy = Policy::load("push.safetensors".as_ref())?;
//! // What the robot provides: one object, 25 numbers observed, 4 numbers in an action.
//! let robot = EnvSpec::<1>::new("my-robot", 25, 4, 50);
//! let mut actor = policy.actor(&robot)?;
//! let desired = Desired::of_task([Position::new(1.3, 0.7, 0.42)]);
//!
//! let (mut observation, mut action) = ([0.0; 25], [0.0; 4]);
//! for _ in 0..robot.episode_steps {
//!     let scene = read_robot(&mut observation);
//!     let task = actor.task();
//!     actor.act(task, &observation, &Achieved(scene), &desired, &mut action)?;
//!     move_robot(&action);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! With several objects, call [`Actor::begin`] at the beginning of an episode: where the task allows
//! every order, the policy then chooses in which order to place them.
//!
//! `examples/control_loop` is a complete control loop with a fixed rate, a watchdog and action
//! limits, also for an arm behind topics, as in ROS 2.
//!
//! # Goals and rewards
//!
//! [`Stage::of`] finds the stage of a scene, [`EncodedGoal`] is what the network sees of a goal in
//! a sub-task, and [`EncodedGoal::reward`] is the one reward that training, hindsight and
//! evaluation share.
//!
//! ```
//! use rher_core::{Achieved, Desired, EncodedGoal, Position, Scene, Stage, Tolerances};
//!
//! let block = Position::new(0.3, 0.1, 0.0);
//! let now = Achieved(Scene::new(Position::origin(), [block]));
//! let desired = Desired::of_task([Position::new(0.4, 0.1, 0.0)]);
//! let tolerances = Tolerances::uniform(0.05);
//!
//! // The hand is far from the block, so the relay is in its first stage: reach the block.
//! let stage = Stage::of(&now, &desired, &tolerances, 0.03);
//! assert_eq!(stage, Stage::FIRST);
//!
//! // In that sub-task, the block's position is the gripper's goal, and the block's slot is blank.
//! let goal = EncodedGoal::new(stage, &now, &desired);
//! assert_eq!(goal.gripper(), Some(block));
//! assert_eq!(goal.objects(), &[None]);
//! assert_eq!(goal.reward(&now, &tolerances), -1.0);
//! ```
//!
//! `docs/tour.md` in the repository explains the whole method in the same way, from an episode to
//! an update.
//!
//! # Reproducibility
//!
//! The same seed gives the same policy, bit for bit, for any number of threads, and also when the
//! run is stopped and resumed: every random draw comes from a stream that is a function of the
//! seed, a purpose and a count.
//!
//! # Features
//!
//! | feature | default | what it adds |
//! |---|---|---|
//! | `fused` | yes | training with the fused CPU engine, the fast one |
//! | `burn` | yes | training with Burn's automatic differentiation, the reference |
//! | `train` | by the above | the training loop, checkpoints and evaluation |
//!
//! Without default features, the crate loads policies and acts with them, and builds neither Burn
//! nor the training loop.

#[doc(hidden)]
pub mod batch;
mod choice;
pub mod config;
mod control;
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
mod names;
#[doc(hidden)]
pub mod normal;
pub mod policy;
#[doc(hidden)]
pub mod relabel;
#[doc(hidden)]
pub mod replay;
#[doc(hidden)]
pub mod seed;
mod setting;
mod since_6;
mod symmetry;
pub mod testing;
#[cfg(feature = "train")]
pub mod train;

pub use config::{ConfigError, Preset, TrainConfig};
pub use control::Control;
pub use env::{End, Env, EnvError, EnvSpec, Mirror, Permutation, SignedIndex, SpecError, Start};
pub use episode::{ActError, Episode, RolloutError, View, rollout};
#[cfg(feature = "train")]
pub use evaluate::{Evaluation, evaluate};
pub use event::{Event, Metrics, Observer, ObserverError};
pub use goal::{
    Achieved, Desired, EncodedGoal, Leg, Metric, Position, Scene, Stage, TailError, TailPart,
    TailSpec, Tails, Tolerances,
};
pub use names::Names;
pub use policy::{Actor, Mismatch, Policy, PolicyError, PolicyInfo, RunId};
#[cfg(feature = "onnx")]
pub use policy::{OnnxError, OnnxModel};
#[cfg(feature = "train")]
pub use train::{Finish, Pretrained, TrainError, Trainer, run_id};

/// The crate whose points are [`Position`]s.
pub use nalgebra;

/// The code of the page on robots is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/robots.md")]
struct Robots;

/// The code of the tour is compiled and run.
#[cfg(all(doctest, feature = "fused"))]
#[doc = include_str!("../../../docs/tour.md")]
struct Tour;

/// So is that of the tutorial.
#[cfg(all(doctest, feature = "fused"))]
#[doc = include_str!("../../../docs/environment-rust.md")]
struct EnvironmentTutorial;
