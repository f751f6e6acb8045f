//! Where in an observation the gripper and the objects are, and what else a policy of someone else's
//! environment has to know of its numbers.

use crate::limits::Limits;
use crate::symmetries::Symmetries;
use rher_envs::{EnvVisitor, OptionError, Options, Simulated, Task};
use serde::{Deserialize, Serialize};

/// Indices of the first number of each position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Places {
    pub(crate) gripper: usize,
    /// In relay order; None where one of them is not in the observation.
    pub(crate) objects: Option<Vec<usize>>,
    /// Numbers of a position, 2 or 3: one of two numbers has no height.
    #[serde(default = "three", skip_serializing_if = "is_three")]
    pub(crate) axes: usize,
    /// Of the environment's actions; None where they are within −1 and 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) limits: Option<Limits>,
    /// What a run was told of them, for they are part of what it learns from.
    #[serde(default, skip_serializing_if = "Symmetries::is_none")]
    pub(crate) symmetries: Symmetries,
}

fn three() -> usize {
    3
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "Serde passes a reference")]
fn is_three(axes: &usize) -> bool {
    *axes == 3
}

impl Places {
    /// Those of a task; None if its observation does not have the gripper.
    pub(crate) fn of_task(task: Task, options: &Options) -> Result<Option<Self>, OptionError> {
        struct Find;

        impl EnvVisitor for Find {
            type Output = Option<Places>;

            fn visit<const N: usize, E: Simulated<N>>(
                self,
                build: impl Fn() -> E + Sync,
            ) -> Option<Places> {
                let rher_envs::Places { gripper, objects } = build().places();
                let objects = objects.into_iter().collect();
                let symmetries = Symmetries::default();
                Some(Places { gripper: gripper?, objects, axes: 3, limits: None, symmetries })
            }
        }

        task.visit_with(options, Find)
    }
}
