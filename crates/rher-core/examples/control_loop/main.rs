//! A policy on an arm: a control loop at a fixed rate, with a watchdog and limits.
//!
//! Run it with `cargo run --release -p rher-core --example control_loop -- POLICY.safetensors [FAULT]`.

mod arm;

pub(crate) use arm::{Arm, Fault, Reading, SimulatedArm};
use rher_core::{ActError, Desired, EnvSpec, Mismatch, Policy, Position};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// When to hold, when to stop, and how far an action may go.
pub(crate) struct Limits {
    pub(crate) period: Duration,
    /// A reading that is older than this is late, and the arm holds.
    pub(crate) latest: Duration,
    /// Consecutive periods without a usable reading after which the arm stops.
    pub(crate) patience: u32,
    /// Largest magnitude of a number in an action.
    pub(crate) action: f32,
    /// Largest change of a number from one action to the next.
    pub(crate) change: f32,
}

/// Why the arm was stopped before its time.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Stopped {
    #[error("the policy is not for this arm")]
    OtherArm(#[from] Mismatch),
    #[error("the driver delivers readings that the policy cannot take")]
    Wiring(#[source] ActError),
    #[error("no usable reading for {0} periods: late, frozen, or not finite")]
    Blind(u32),
}

/// Acts for an episode; whatever happens, the arm is stopped before this returns.
pub(crate) fn control(
    arm: &mut impl Arm,
    spec: &EnvSpec<1>,
    policy: &Policy,
    desired: &Desired<1>,
    limits: &Limits,
) -> Result<(), Stopped> {
    let outcome = act_at_a_fixed_rate(arm, spec, policy, desired, limits);
    arm.stop();
    outcome
}

fn act_at_a_fixed_rate(
    arm: &mut impl Arm,
    spec: &EnvSpec<1>,
    policy: &Policy,
    desired: &Desired<1>,
    limits: &Limits,
) -> Result<(), Stopped> {
    let mut actor = policy.actor(spec)?;
    let (mut action, mut last) = (vec![0.0; spec.action_dim], vec![0.0; spec.action_dim]);
    let (mut blind, mut seen) = (0, None);
    let start = Instant::now();
    for step in 1..=spec.episode_steps as u32 {
        let Reading { taken, observation, scene } = arm.read();
        let is_new = seen.replace(taken) != Some(taken) && taken.elapsed() <= limits.latest;
        match actor.act(actor.task(), &observation, &scene, desired, &mut action) {
            Err(error @ ActError::Length { .. }) => return Err(Stopped::Wiring(error)),
            Ok(()) if is_new => {
                for (number, last) in action.iter_mut().zip(&mut last) {
                    let near = number.clamp(*last - limits.change, *last + limits.change);
                    *number = near.clamp(-limits.action, limits.action);
                    *last = *number;
                }
                arm.carry_out(&action);
                blind = 0;
            }
            _ if blind == limits.patience => return Err(Stopped::Blind(blind)),
            _ => {
                arm.hold();
                blind += 1;
            }
        }
        sleep((limits.period * step).saturating_sub(start.elapsed()));
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let policy =
        Policy::load(arguments.next().ok_or("expected the path of a policy file")?.as_ref())?;
    let fault = arguments.next().map_or(Ok(Fault::None), |name| Fault::named(&name))?;
    let info = policy.info();
    let spec = EnvSpec::new("arm", info.obs_dim, info.action_dim, 50);
    let rate = policy.control().rate_hz.ok_or("the policy does not say how fast it acts")?;
    let period = Duration::from_secs_f32(1.0 / rate);
    let limits = Limits { period, latest: 2 * period, patience: 5, action: 0.8, change: 0.4 };
    let desired = Desired::of_task([Position::new(1.3, 0.7, 0.42)]);
    let mut arm = SimulatedArm::new(info.obs_dim, fault);
    Ok(control(&mut arm, &spec, &policy, &desired, &limits)?)
}
