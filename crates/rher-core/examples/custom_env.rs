//! Trains on an environment of your own: a hand in a box that carries what it touches.
//!
//! Run it with `cargo run --release -p rher-core --example custom_env`.

use rand::{RngExt as _, SeedableRng as _};
use rher_core::config::Preset;
use rher_core::env::{Env, EnvError, EnvSpec, Start};
use rher_core::event::Event;
use rher_core::goal::{Achieved, Desired, Position, Scene};
use rher_core::train::Trainer;
use std::sync::atomic::AtomicBool;

struct Carry {
    spec: EnvSpec<1>,
    scene: Scene<1>,
}

impl Env<1> for Carry {
    fn spec(&self) -> &EnvSpec<1> {
        &self.spec
    }

    fn reset(&mut self, seed: u64, observation: &mut [f32]) -> Result<Start<1>, EnvError> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut anywhere = || Position::new(rng.random(), rng.random(), 0.0);
        self.scene = Scene::new(anywhere(), [anywhere()]);
        observation.copy_from_slice((self.scene.gripper - self.scene.objects[0]).as_slice());
        Ok(Start { achieved: Achieved(self.scene), desired: Desired::of_task([anywhere()]) })
    }

    fn step(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Achieved<1>, EnvError> {
        let held = nalgebra::distance(&self.scene.gripper, &self.scene.objects[0]) < 0.08;
        self.scene.gripper.x = (self.scene.gripper.x + 0.1 * action[0]).clamp(0.0, 1.0);
        self.scene.gripper.y = (self.scene.gripper.y + 0.1 * action[1]).clamp(0.0, 1.0);
        self.scene.objects[0] = if held { self.scene.gripper } else { self.scene.objects[0] };
        observation.copy_from_slice((self.scene.gripper - self.scene.objects[0]).as_slice());
        Ok(Achieved(self.scene))
    }
}

#[expect(clippy::print_stdout, reason = "an example talks to its reader")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut config = Preset::Fast.config("carry", 1);
    config.env_steps = 10_000;
    config.agent.hidden = vec![64, 64];
    let scene = Scene::new(Position::origin(), [Position::origin()]);
    let env = Carry { spec: EnvSpec::new("carry", 3, 2, 25), scene };
    let mut trainer = Trainer::new(config, vec![env], 1)?;
    let mut print = |event: &Event| {
        if let Event::Evaluated(metrics) = event {
            println!("{:6} steps: {:?}", metrics.env_steps, metrics.success);
        }
        Ok(())
    };
    trainer.run(None, &mut print, &AtomicBool::new(false))?;
    Ok(trainer.policy().save("carry.safetensors".as_ref())?)
}
