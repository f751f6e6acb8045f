//! A world of one action, in which the right value of every state is known.

use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::goal::{Achieved, Desired, Position, Scene, Tolerances};
use rher_core::{Control, Names};

/// How far an action moves the gripper, in meters.
const STRIDE: f32 = 0.1;

/// A gripper that goes where its action says, and a target that one action can or cannot reach: the
/// right value of every state is known.
pub(crate) struct Probe {
    spec: EnvSpec<1>,
    target: f32,
}

impl Probe {
    /// With its only target at `target` on the x axis; the gripper reaches −0.1 to 0.1, and an
    /// object is wherever the gripper is.
    pub(crate) fn new(target: f32) -> Self {
        Self {
            spec: EnvSpec {
                name: "probe".to_owned(),
                variant: String::new(),
                obs_dim: 1,
                action_dim: 1,
                episode_steps: 5,
                subtasks: 2,
                tolerances: Tolerances::uniform(0.05),
                mirrors: Vec::new(),
                permutations: Vec::new(),
                any_order: false,
                names: Names::default(),
                control: Control::default(),
            },
            target,
        }
    }
}

impl Env<1> for Probe {
    fn spec(&self) -> &EnvSpec<1> {
        &self.spec
    }

    fn reset(&mut self, _seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
        observation[0] = 1.0;
        let here = Position::origin();
        let desired = Desired::of_task([Position::new(self.target, 0.0, 0.0)]);
        Ok(Start { achieved: Achieved(Scene::new(here, [here])), desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
        observation[0] = 1.0;
        let here = Position::new(STRIDE * action[0], 0.0, 0.0);
        Ok(Achieved(Scene::new(here, [here])))
    }
}
