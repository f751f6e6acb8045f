//! `rher`, with a task that no simulator knows: a hand on a line reaches for a place.
//!
//! Run it with `cargo run --release -p rher-cli --example line -- train line`.

use rher_cli::Program;
use rher_core::{Achieved, Desired, Env, EnvError, EnvSpec, Position, Scene, Start};
use rher_envs::Simulated;
use std::process::ExitCode;

struct Line {
    spec: EnvSpec<1>,
    hand: f32,
    target: Position,
}

impl Line {
    fn new() -> Self {
        let mut spec = EnvSpec::new("line", 1, 1, 10);
        spec.subtasks = 1;
        Self { spec, hand: 0.0, target: Position::origin() }
    }

    fn observe(&self, observation: &mut [f32]) -> Achieved<1> {
        observation[0] = self.hand;
        let gripper = Position::new(self.hand, 0.0, 0.0);
        Achieved(Scene::new(gripper, [self.target]))
    }
}

impl Env<1> for Line {
    fn spec(&self) -> &EnvSpec<1> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
        self.hand = 0.0;
        self.target.x = (seed % 11) as f32 / 10.0 - 0.5;
        let desired = Desired::of_task([self.target]);
        Ok(Start { achieved: self.observe(observation), desired })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
        self.hand += 0.1 * action[0];
        Ok(self.observe(observation))
    }
}

impl Simulated<1> for Line {}

fn main() -> ExitCode {
    Program::new().env(Line::new).main()
}
