//! Shoves a block off its center and prints how it turns and how far it coasts.
//!
//! ```console
//! $ cargo run --release -p rher-envs --example shove
//! ```

use rher_core::env::{Env as _, EnvError};
use rher_core::goal::Position;
use rher_envs::tasks::Push;
use rher_envs::{Layout, Simulated as _, Simulation};

/// Index of the block's yaw in an observation.
const YAW: usize = 13;

#[expect(clippy::print_stdout, reason = "a program for the terminal")]
fn main() -> Result<(), EnvError> {
    let mut env = Simulation::<Push, 1>::new();
    let mut observation = vec![0.0; env.spec().obs_dim];
    println!("off center (mm)  shoved by (mm)  coasts (mm)  turns (degrees)");
    for aside in [-0.03, -0.02, -0.01, 0.0, 0.01, 0.02, 0.03] {
        let home = env.reset(0, &mut observation)?.achieved.0.gripper;
        let block = Position::new(home.x - 0.11, home.y + aside, 0.42489);
        env.arrange(Layout::new([block], [block]), &mut observation)?;
        let mut released = block;
        for _ in 0..5 {
            released = env.step(&[-1.0, 0.0, 0.05, 0.0], &mut observation)?.0.objects[0];
        }
        let mut at_rest = released;
        for _ in 0..20 {
            at_rest = env.step(&[1.0, 0.0, 0.5, 0.0], &mut observation)?.0.objects[0];
        }
        println!(
            "{:>15.0} {:>15.0} {:>12.0} {:>16.0}",
            1000.0 * aside,
            1000.0 * (released - block).norm(),
            1000.0 * (at_rest - released).norm(),
            observation[YAW].to_degrees(),
        );
    }
    Ok(())
}
