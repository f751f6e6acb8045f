//! The goals of a task as those outside see them: one position for each object.

use rher_core::env::EnvSpec;
use rher_core::goal::{Achieved, Desired, EncodedGoal, Leg, Position, Scene};

/// What is compared with the places where the objects should be: where they are, or where the
/// gripper is if the task is to reach.
pub fn achieved_goal<const N: usize>(spec: &EnvSpec<N>, achieved: &Achieved<N>) -> [Position; N] {
    match spec.last_stage().leg() {
        Leg::Reach => [achieved.0.gripper; N],
        Leg::Place => achieved.0.objects,
    }
}

/// What a step of the last sub-task is rewarded by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RewardKind {
    /// 0 where every object is at its place, −1 elsewhere.
    Sparse,
    /// Minus the length of what separates achieved and desired goals, over all objects, in meters.
    Dense,
}

impl RewardKind {
    /// The reward in a scene of a task that asks for `desired`.
    pub fn of_scene<const N: usize>(
        self,
        spec: &EnvSpec<N>,
        achieved: &Achieved<N>,
        desired: &Desired<N>,
    ) -> f32 {
        match self {
            Self::Sparse => {
                let goal = EncodedGoal::new(spec.last_stage(), achieved, desired);
                goal.reward(achieved, &spec.tolerances)
            }
            Self::Dense => -distance(&achieved_goal(spec, achieved), desired.objects()),
        }
    }

    /// The reward where `achieved` is the [`achieved_goal`] and `desired` says where the objects
    /// should be.
    pub fn of_goals<const N: usize>(
        self,
        spec: &EnvSpec<N>,
        achieved: [Position; N],
        desired: [Position; N],
    ) -> f32 {
        let scene = match spec.last_stage().leg() {
            // What is to be reached stays where it is.
            Leg::Reach => Scene::new(achieved[0], desired),
            Leg::Place => Scene::new(Position::origin(), achieved),
        };
        self.of_scene(spec, &Achieved(scene), &Desired::of_task(desired))
    }
}

/// The length of the difference of two goals, in meters.
fn distance<const N: usize>(achieved: &[Position; N], desired: &[Position; N]) -> f32 {
    let pairs = achieved.iter().zip(desired);
    pairs.map(|(a, d)| nalgebra::distance_squared(a, d)).sum::<f32>().sqrt()
}
