//! The inputs of the graph: the parts of an observation of a `GoalEnv`, in rows.
//!
//! Shapes in comments are those of a batch of B rows, with N objects.

use super::graph::{Graph, Value, whole};
use crate::goal::Leg;
use crate::policy::{Policy, PolicyInfo};

/// What is known of a scene in a row.
#[derive(Clone, Copy)]
pub(super) struct Scene<'g> {
    /// `[B, 1, 3]`.
    pub(super) gripper: Value<'g>,
    /// `[B, N, 3]`.
    pub(super) objects: Value<'g>,
}

/// What the inputs of the graph are.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'a> {
    info: &'a PolicyInfo,
    /// Where in an observation the three numbers of the gripper's position begin.
    gripper: usize,
    chooses_order: bool,
}

impl<'a> Inputs<'a> {
    /// Those of a policy, in whose observations the three numbers of the gripper's position begin at
    /// `gripper`.
    pub(super) fn new(policy: &'a Policy, gripper: usize) -> Self {
        let Policy { info, encoder, .. } = policy;
        Self { info, gripper, chooses_order: encoder.order().is_some() }
    }

    /// All of them, with their widths.
    pub(super) fn all(&self) -> Vec<(&'static str, usize)> {
        let PolicyInfo { obs_dim, objects, .. } = *self.info;
        let mut inputs = vec![
            ("observation", obs_dim),
            ("achieved_goal", 3 * objects),
            ("desired_goal", 3 * objects),
        ];
        if self.chooses_order {
            let begun = [("first_observation", obs_dim), ("first_achieved_goal", 3 * objects)];
            inputs.extend(begun);
        }
        inputs
    }

    /// Those that an action follows from.
    pub(super) fn used(&self) -> impl Iterator<Item = &'static str> {
        let is_ignored = |name: &str| self.is_reach() && name.ends_with("achieved_goal");
        self.all().into_iter().map(|(name, _)| name).filter(move |name| !is_ignored(name))
    }

    /// Number of objects.
    pub(super) fn objects(&self) -> usize {
        self.info.objects
    }

    /// The object that the last sub-task is about, counted from 0.
    pub(super) fn last(&self) -> usize {
        (self.info.subtasks - 1) / 2
    }

    /// Whether the last sub-task is to reach that object, and not to place it.
    pub(super) fn is_reach(&self) -> bool {
        Leg::of_subtask(self.info.subtasks - 1) == Leg::Reach
    }

    /// The scene of an observation and of where the objects are. What is to be reached stays where it
    /// is.
    pub(super) fn scene<'g>(
        &self,
        graph: &'g Graph,
        observation: &'static str,
        achieved: &'static str,
    ) -> Scene<'g> {
        let at = graph.constant(&[3], (self.gripper..self.gripper + 3).map(whole));
        let gripper = graph.input(observation).gathered(at, 1);
        let objects = if self.is_reach() { "desired_goal" } else { achieved };
        Scene {
            gripper: gripper.reshaped([1, 3]),
            objects: graph.input(objects).reshaped([self.info.objects, 3]),
        }
    }

    /// Where the objects should be, `[B, N, 3]`.
    pub(super) fn targets<'g>(&self, graph: &'g Graph) -> Value<'g> {
        graph.input("desired_goal").reshaped([self.info.objects, 3])
    }
}
