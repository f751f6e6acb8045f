//! An environment whose task is known at run time only.

use crate::picture::Painter;
use nalgebra::Point3;
use rher_core::env::{EnvError, EnvSpec, Start};
use rher_core::goal::{Achieved, Desired, EncodedGoal, Position};
use rher_envs::render::Image;
use rher_envs::{
    Chosen, EnvVisitor, OptionError, Options, RewardKind, Simulated, Task, achieved_goal,
};

/// What an environment shows, in Gymnasium's terms.
#[derive(Clone)]
pub(crate) struct Frame {
    /// As wide as the task's observation.
    pub(crate) observation: Vec<f32>,
    /// `[3 N]`, in meters.
    pub(crate) achieved: Vec<f32>,
    /// `[3 N]`, in meters.
    pub(crate) desired: Vec<f32>,
    /// Of the last step.
    pub(crate) reward: f32,
    /// Whether the task was solved after the last step.
    pub(crate) success: bool,
}

/// Widths and limits of an environment.
#[derive(Clone, Copy)]
pub(crate) struct Widths {
    pub(crate) observation: usize,
    pub(crate) action: usize,
    pub(crate) objects: usize,
    pub(crate) episode_steps: usize,
    /// Distance below which a goal counts as reached, in meters.
    pub(crate) tolerance: f32,
}

/// What an environment can return to.
pub(crate) struct Snapshot {
    /// Of the simulation; none of one that cannot be kept.
    env: Option<rher_envs::Snapshot>,
    /// Where the objects should go, `[3 N]`.
    desired: Vec<f32>,
    frame: Frame,
}

/// An environment, whatever its task.
pub(crate) trait AnyEnv: Send {
    fn widths(&self) -> Widths;

    /// Starts the episode of `seed`, with the part of its layout that is chosen.
    fn reset(&mut self, seed: u64, chosen: &Chosen) -> Result<(), EnvError>;

    /// Acts for one step of an episode that was started.
    fn step(&mut self, action: &[f32]) -> Result<(), EnvError>;

    /// What it shows now.
    fn frame(&self) -> &Frame;

    fn snapshot(&self) -> Snapshot;

    /// Returns to a snapshot; false if it is of an environment of another task or with other options.
    fn restore(&mut self, snapshot: &Snapshot) -> bool;

    /// A picture of this moment of an episode that was started.
    fn picture(&mut self, painter: &mut Painter) -> Result<Image, EnvError>;

    /// Rewards for rows of achieved and desired goals.
    fn rewards(&self, achieved: &[f32], desired: &[f32]) -> Vec<f32>;
}

/// Makes an environment of `task` that rewards by `kind`.
pub(crate) fn build(
    task: Task,
    options: &Options,
    kind: RewardKind,
) -> Result<Box<dyn AnyEnv>, OptionError> {
    struct Build(RewardKind);

    impl EnvVisitor for Build {
        type Output = Box<dyn AnyEnv>;

        fn visit<const N: usize, E: Simulated<N>>(
            self,
            build: impl Fn() -> E + Sync,
        ) -> Box<dyn AnyEnv> {
            Box::new(Shown::new(build(), self.0))
        }
    }

    task.visit_with(options, Build(kind))
}

/// An environment and what it shows.
struct Shown<E, const N: usize> {
    env: E,
    kind: RewardKind,
    desired: Desired<N>,
    frame: Frame,
}

impl<E: Simulated<N>, const N: usize> Shown<E, N> {
    fn new(env: E, kind: RewardKind) -> Self {
        let zeros = |width: usize| vec![0.0; width];
        let frame = Frame {
            observation: zeros(env.spec().obs_dim),
            achieved: zeros(3 * N),
            desired: zeros(3 * N),
            reward: 0.0,
            success: false,
        };
        Self { env, kind, desired: Desired::of_task([Position::origin(); N]), frame }
    }

    fn show(&mut self, achieved: &Achieved<N>) {
        let spec = self.env.spec();
        write(&achieved_goal(spec, achieved), &mut self.frame.achieved);
        let goal = EncodedGoal::new(spec.last_stage(), achieved, &self.desired);
        self.frame.reward = self.kind.of_scene(spec, achieved, &self.desired);
        self.frame.success = goal.is_met(achieved, &spec.tolerances);
    }
}

impl<E: Simulated<N>, const N: usize> AnyEnv for Shown<E, N> {
    fn widths(&self) -> Widths {
        let EnvSpec { obs_dim: observation, action_dim: action, episode_steps, tolerances, .. } =
            self.env.spec();
        let of_gripper = self.env.spec().last_stage().index() == 0;
        Widths {
            observation: *observation,
            action: *action,
            objects: N,
            episode_steps: *episode_steps,
            tolerance: if of_gripper { tolerances.gripper } else { tolerances.objects[0] },
        }
    }

    fn reset(&mut self, seed: u64, chosen: &Chosen) -> Result<(), EnvError> {
        let start = self.env.reset_with(seed, chosen, &mut self.frame.observation)?;
        let Start { achieved, desired } = start;
        self.desired = desired;
        write(desired.objects(), &mut self.frame.desired);
        self.show(&achieved);
        Ok(())
    }

    fn step(&mut self, action: &[f32]) -> Result<(), EnvError> {
        let achieved = self.env.step(action, &mut self.frame.observation)?;
        self.show(&achieved);
        Ok(())
    }

    fn frame(&self) -> &Frame {
        &self.frame
    }

    fn snapshot(&self) -> Snapshot {
        let desired = self.desired.objects().iter().flat_map(|place| [place.x, place.y, place.z]);
        Snapshot { env: self.env.snapshot(), desired: desired.collect(), frame: self.frame.clone() }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> bool {
        let Snapshot { env, desired, frame } = snapshot;
        let restored = env.as_ref().is_some_and(|state| self.env.return_to(state).is_ok());
        if restored {
            self.desired = Desired::of_task(read(desired));
            self.frame.clone_from(frame);
        }
        restored
    }

    fn picture(&mut self, painter: &mut Painter) -> Result<Image, EnvError> {
        painter.draw(&mut self.env, read(&self.frame.achieved), &self.desired)
    }

    fn rewards(&self, achieved: &[f32], desired: &[f32]) -> Vec<f32> {
        let rows = achieved.chunks_exact(3 * N).zip(desired.chunks_exact(3 * N));
        let spec = self.env.spec();
        rows.map(|(achieved, desired)| self.kind.of_goals(spec, read(achieved), read(desired)))
            .collect()
    }
}

fn write<const N: usize>(positions: &[Position; N], row: &mut [f32]) {
    for (position, out) in positions.iter().zip(row.chunks_exact_mut(3)) {
        out.copy_from_slice(position.coords.as_slice());
    }
}

/// The positions in a row of 3 N numbers.
pub(crate) fn read<const N: usize>(row: &[f32]) -> [Position; N] {
    std::array::from_fn(|i| Point3::from_slice(&row[3 * i..3 * i + 3]))
}
