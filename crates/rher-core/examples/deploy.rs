//! Loads a policy file and acts in a control loop: what runs beside a robot.
//!
//! Run it with `cargo run --release -p rher-core --example deploy -- POLICY.safetensors`.

use rher_core::goal::{Achieved, Desired, Position, Scene, Stage};
use rher_core::policy::Policy;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Where a real controller reads its encoders and its camera.
fn read_robot(observation: &mut [f32]) -> Achieved<1> {
    observation.fill(0.0);
    let gripper = Position::new(1.34, 0.75, 0.53);
    Achieved(Scene { gripper, objects: [Position::new(1.4, 0.8, 0.42)] })
}

#[expect(clippy::print_stdout, reason = "an example talks to its reader")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("expected the path of a policy file")?;
    let policy = Policy::load(&PathBuf::from(path))?;
    let about = policy.info();
    let task = Stage::<1>::from_index(about.subtasks - 1).ok_or("expected one object")?;
    let desired = Desired::of_task([Position::new(1.3, 0.7, 0.42)]);

    let mut actor = policy.actor();
    let mut observation = vec![0.0; about.obs_dim];
    let mut action = vec![0.0; about.action_dim];
    for step in 0..25 {
        let period = Instant::now();
        let achieved = read_robot(&mut observation);
        actor.act(task, &observation, &achieved, &desired, &mut action);
        println!("step {step}: {action:.3?} in {:?}", period.elapsed());
        std::thread::sleep(Duration::from_millis(40).saturating_sub(period.elapsed()));
    }
    Ok(())
}
