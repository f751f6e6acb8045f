//! What is written in a picture of an episode.

use rher_core::env::EnvSpec;
use rher_core::evaluate::Played;
use rher_core::goal::{Achieved, Leg, Stage, Tolerances};
use rher_envs::Task;
use rher_envs::render::Image;
use rher_envs::thing::object_color;
use std::array;

const WHITE: [u8; 3] = [0xff; 3];
const GREEN: [u8; 3] = [0x7c, 0xe0, 0x7c];

/// Writes how far an episode is: step, sub-task, distance, success.
pub(crate) struct Captions<const N: usize> {
    subtasks: Vec<String>,
    tolerances: Tolerances<N>,
    last: Stage<N>,
    steps: usize,
    reach_distance: f32,
}

impl<const N: usize> Captions<N> {
    pub(crate) fn new(spec: &EnvSpec<N>, task: Task, reach_distance: f32) -> Self {
        Self {
            subtasks: task.subtasks(),
            tolerances: spec.tolerances,
            last: spec.last_stage(),
            steps: spec.episode_steps,
            reach_distance,
        }
    }

    /// Writes into the picture that was taken after `step` steps.
    pub(crate) fn write(
        &self,
        played: &Played<N>,
        step: usize,
        is_solved: bool,
        image: &mut Image,
    ) {
        let Current { object, leg, distance } = self.current(played, step, is_solved);
        let subtask = 2 * object + usize::from(leg == Leg::Place);
        let name = self.subtasks.get(subtask).map_or("", String::as_str);
        let widest = self.subtasks.iter().map(String::len).max().unwrap_or(0);
        let steps = self.steps;
        let digits = steps.to_string().len();
        let count = format!("step {step:>digits$}/{steps}");
        let name = format!("{name:widest$}");
        let target = if leg == Leg::Place { "goal" } else { "object" };
        let distance = format!("{:>4.1} cm to {target}", 100.0 * distance);
        let success = if is_solved { "success" } else { "" };
        image.caption(&[
            (&count, WHITE),
            (&name, ink(object)),
            (&distance, WHITE),
            (success, GREEN),
        ]);
    }

    /// The sub-task in the policy's order of the objects; the last one if all is well.
    fn current(&self, played: &Played<N>, step: usize, is_solved: bool) -> Current {
        let order = played.order.as_ref().map_or_else(|| array::from_fn(|i| i), |it| it.order);
        let (now, desired) = (&played.episode.achieved[step], &played.episode.desired);
        let stage = Stage::of(
            &Achieved(now.0.reordered(&order)),
            &desired.reordered(&order),
            &self.tolerances,
            self.reach_distance,
        );
        let stage = if is_solved { self.last } else { stage.at_most(self.last) };
        let object = order[stage.object()];
        let place = &now.0.objects[object];
        let wanted = match stage.leg() {
            Leg::Reach => &now.0.gripper,
            Leg::Place => &desired.objects()[object],
        };
        Current { object, leg: stage.leg(), distance: (place - wanted).norm() }
    }
}

/// What an episode is at.
struct Current {
    object: usize,
    leg: Leg,
    /// From the object to the gripper that reaches it, or to its goal, in meters.
    distance: f32,
}

/// The color of an object, light enough to be read on a dark ground.
fn ink(object: usize) -> [u8; 3] {
    let [r, g, b, _] = object_color(object);
    [r, g, b].map(|level| (255.0 * (0.5 + 0.5 * level)) as u8)
}
