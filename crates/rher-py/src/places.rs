//! Where in an observation the gripper and the objects are.

use rher_core::goal::{Achieved, Position};
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
    /// Those of a task, found by watching an episode of it.
    pub(crate) fn of_task(task: Task, options: &Options) -> Result<Option<Self>, OptionError> {
        task.visit_with(options, Watch)
    }
}

struct Watch;

impl EnvVisitor for Watch {
    type Output = Option<Places>;

    fn visit<const N: usize, E: Simulated<N>>(
        self,
        build: impl Fn() -> E + Sync,
    ) -> Option<Places> {
        let mut env = build();
        let mut observation = vec![0.0; env.spec().obs_dim];
        let action = vec![0.3; env.spec().action_dim];
        let last = observation.len().checked_sub(3)?;
        let mut candidates = vec![(0..=last).collect::<Vec<_>>(); N + 1];
        for seed in 0..2 {
            let mut achieved = env.reset(seed, &mut observation).ok()?.achieved;
            for _ in 0..5 {
                narrow(&mut candidates, &achieved, &observation);
                achieved = env.step(&action, &mut observation).ok()?;
            }
            narrow(&mut candidates, &achieved, &observation);
        }
        let mut found = candidates.iter().map(|places| places.first().copied());
        let gripper = found.next()??;
        Some(Places { gripper, objects: found.collect() })
    }
}

/// Drops the places that hold something else than the gripper's and the objects' positions.
fn narrow<const N: usize>(
    candidates: &mut [Vec<usize>],
    Achieved(scene): &Achieved<N>,
    observation: &[f32],
) {
    let things = std::iter::once(&scene.gripper).chain(&scene.objects);
    for (places, thing) in candidates.iter_mut().zip(things) {
        places.retain(|&place| Position::from_slice(&observation[place..place + 3]) == *thing);
    }
}
