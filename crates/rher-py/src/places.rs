//! Where in an observation the gripper and the objects are.

use rher_envs::{EnvVisitor, OptionError, Options, Simulated, Task};
use serde::{Deserialize, Serialize};

/// Indices of the first of three numbers each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Places {
    pub(crate) gripper: usize,
    /// In relay order; None where one of them is not in the observation.
    pub(crate) objects: Option<Vec<usize>>,
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
                Some(Places { gripper: gripper?, objects: objects.into_iter().collect() })
            }
        }

        task.visit_with(options, Find)
    }
}
