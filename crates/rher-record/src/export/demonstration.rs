//! An episode as those who learn from demonstrations keep it.

use crate::message::{Action, Begin, Frame, Message, Place, Timed};
use crate::{Recorded, RecordingInfo};
use rher_core::goal::Leg;

/// An episode as demonstrations are kept: flat rows, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Demonstration {
    /// Seed that the environment was reset with.
    pub seed: u64,
    /// T.
    pub steps: usize,
    /// `[T + 1, observation]`.
    pub observations: Vec<f32>,
    /// `[T + 1, goal]`: where the objects are, in meters; where the gripper is if the task is to
    /// reach.
    pub achieved: Vec<f32>,
    /// `[goal]`: where the same should be, in meters.
    pub desired: Vec<f32>,
    /// `[T, action]`, as they were carried out, in [−1, 1].
    pub actions: Vec<f32>,
    /// `[T]`.
    pub rewards: Vec<f32>,
    /// `[T + 1]`: whether the task is solved.
    pub successes: Vec<bool>,
}

impl Demonstration {
    /// An episode that was just played: its messages.
    ///
    /// # Panics
    ///
    /// If the beginning of an episode is not among them.
    pub fn played(info: &RecordingInfo, messages: &[Timed]) -> Self {
        let mut begins = Vec::new();
        let (mut frames, mut actions) = (Vec::new(), Vec::new());
        for Timed { message, .. } in messages {
            match message {
                Message::Begin(begin) => begins.push(begin.clone()),
                Message::Frame(frame) => frames.push(frame.clone()),
                Message::Action(action) => actions.push(action.clone()),
                Message::Transforms(_) | Message::Scene(_) => {}
            }
        }
        Self::of(info, &begins[0], &frames, &actions)
    }

    /// An episode that was recorded.
    pub fn recorded(info: &RecordingInfo, recorded: &Recorded) -> Self {
        let Recorded { begin, frames, actions, .. } = recorded;
        Self::of(info, begin, frames, actions)
    }

    fn of(info: &RecordingInfo, begin: &Begin, frames: &[Frame], actions: &[Action]) -> Self {
        let flat = |places: &[Place]| places.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let achieved = |frame: &Frame| -> Vec<f32> {
            match info.last_leg() {
                Leg::Reach => flat(&vec![frame.gripper; frame.objects.len()]),
                Leg::Place => flat(&frame.objects),
            }
        };
        Self {
            seed: begin.seed,
            steps: begin.steps,
            observations: frames.iter().flat_map(|frame| frame.observation.clone()).collect(),
            achieved: frames.iter().flat_map(achieved).collect(),
            desired: flat(&begin.targets),
            actions: actions
                .iter()
                .flat_map(|action| action.action.iter().map(|x| x.clamp(-1.0, 1.0)))
                .collect(),
            rewards: frames.iter().filter_map(|frame| frame.reward).collect(),
            successes: frames.iter().map(|frame| frame.success).collect(),
        }
    }

    /// Numbers in an observation, in a goal and in an action.
    pub(super) fn widths(&self) -> [usize; 3] {
        let Self { steps, observations, desired, actions, .. } = self;
        [observations.len() / (steps + 1), desired.len(), actions.len() / steps]
    }
}
