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

/// The reward of the last sub-task where `achieved` is the [`achieved_goal`] and `desired` says
/// where the objects should be: −1 or 0.
pub fn reward_of_goals<const N: usize>(
    spec: &EnvSpec<N>,
    achieved: [Position; N],
    desired: [Position; N],
) -> f32 {
    let scene = match spec.last_stage().leg() {
        // What is to be reached stays where it is.
        Leg::Reach => Scene { gripper: achieved[0], objects: desired },
        Leg::Place => Scene { gripper: Position::origin(), objects: achieved },
    };
    let scene = Achieved(scene);
    let goal = EncodedGoal::new(spec.last_stage(), &scene, &Desired::of_task(desired));
    goal.reward(&scene, &spec.tolerances)
}
