//! A policy on an arm: a control loop at the policy's rate, with a watchdog and limits.
//!
//! Run it with `cargo run --release -p rher-core --example control_loop -- POLICY.safetensors [FAULT]`.
//! `topics` instead of a fault puts the arm behind topics, as in ROS 2, in a thread of its own.

mod arm;
pub(crate) mod topics;

pub(crate) use arm::{Arm, Fault, Reading, SimulatedArm};
use rher_core::{ActError, Actor, Control, Desired, EnvSpec, Mismatch, Policy, Position};
use std::time::Duration;
use topics::on_wall_clock;

/// When to hold, when to stop, and how far an action may go.
pub(crate) struct Limits {
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
    #[error("the policy was trained with {policy:?}, and the arm has {arm:?}: expected the same")]
    OtherControl { policy: Box<Control>, arm: Box<Control> },
    #[error("nothing says how many actions a second the arm takes: expected a `rate_hz`")]
    NoRate,
    #[error("the driver delivers readings that the policy cannot take")]
    Wiring(#[source] ActError),
    #[error("no usable reading for {0} periods: late, frozen, lost, or not finite")]
    Blind(u32),
}

/// Acts for an episode; whatever happens, the arm is stopped before this returns.
pub(crate) fn control(
    arm: &mut impl Arm,
    spec: &EnvSpec<1>,
    policy: Policy,
    desired: &Desired<1>,
    limits: Limits,
) -> Result<(), Stopped> {
    let outcome = act_at_a_fixed_rate(arm, spec, policy, desired, limits);
    arm.stop();
    outcome
}

fn act_at_a_fixed_rate(
    arm: &mut impl Arm,
    spec: &EnvSpec<1>,
    policy: Policy,
    desired: &Desired<1>,
    limits: Limits,
) -> Result<(), Stopped> {
    let mut controller = Controller::new(policy, spec, limits)?;
    let mut now = arm.wait_until(Duration::ZERO);
    let mut due = now;
    for _ in 0..spec.episode_steps {
        match controller.decide(arm.read(), now, desired)? {
            Some(action) => arm.carry_out(action),
            None => arm.hold(),
        }
        // What a stall has missed is not made up for in a burst.
        due = if now > due + controller.period { now } else { due } + controller.period;
        now = arm.wait_until(due);
    }
    Ok(())
}

/// From what was read to what the arm should do: all that a node has to keep between two calls.
struct Controller {
    actor: Actor<'static, 1>,
    period: Duration,
    limits: Limits,
    action: Vec<f32>,
    last: Vec<f32>,
    /// When the last reading was taken.
    seen: Option<Duration>,
    /// Consecutive periods without a usable reading.
    blind: u32,
}

impl Controller {
    /// A controller of arms like `spec`, if the policy is for them.
    fn new(policy: Policy, spec: &EnvSpec<1>, limits: Limits) -> Result<Self, Stopped> {
        if *policy.control() != spec.control {
            let [policy, arm] = [policy.control(), &spec.control].map(|it| Box::new(it.clone()));
            return Err(Stopped::OtherControl { policy, arm });
        }
        let rate = spec.control.rate_hz.ok_or(Stopped::NoRate)?;
        let zeros = vec![0.0; spec.action_dim];
        Ok(Self {
            actor: policy.into_actor(spec)?,
            period: Duration::from_secs_f64(1.0 / f64::from(rate)),
            limits,
            action: zeros.clone(),
            last: zeros,
            seen: None,
            blind: 0,
        })
    }

    /// The action at `now` on the arm's clock, or `None` to hold.
    fn decide(
        &mut self,
        reading: Option<Reading>,
        now: Duration,
        desired: &Desired<1>,
    ) -> Result<Option<&[f32]>, Stopped> {
        let is_usable = match reading {
            None => false,
            Some(Reading { taken, observation, scene }) => {
                let is_new = self.seen.replace(taken) != Some(taken);
                let (actor, action) = (&mut self.actor, &mut self.action);
                match actor.act(actor.task(), &observation, &scene, desired, action) {
                    Err(error @ ActError::Length { .. }) => return Err(Stopped::Wiring(error)),
                    Err(_) => false,
                    Ok(()) => is_new && now.saturating_sub(taken) <= self.limits.latest,
                }
            }
        };
        let Limits { patience, action: most, change, .. } = self.limits;
        if !is_usable {
            if self.blind == patience {
                return Err(Stopped::Blind(patience));
            }
            self.blind += 1;
            // A hand that holds is at rest: the next action starts from there.
            self.last.fill(0.0);
            return Ok(None);
        }
        self.blind = 0;
        for (number, last) in self.action.iter_mut().zip(&mut self.last) {
            *number = number.clamp(*last - change, *last + change).clamp(-most, most);
            *last = *number;
        }
        Ok(Some(&self.action))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("expected the path of a policy file")?;
    let policy = Policy::load(path.as_ref())?;
    let info = policy.info();
    // A driver of a real arm writes down its own numbers here, so that a policy that was trained
    // with others is refused.
    let mut spec = EnvSpec::new("arm", info.obs_dim, info.action_dim, 50);
    spec.control = policy.control().clone();
    let rate = spec.control.rate_hz.ok_or(Stopped::NoRate)?;
    let period = Duration::from_secs_f64(1.0 / f64::from(rate));
    let limits = Limits { latest: 2 * period, patience: 5, action: 0.8, change: 0.4 };
    let desired = Desired::of_task([Position::new(1.3, 0.7, 0.42)]);
    match arguments.next().as_deref() {
        Some("topics") => {
            let arm = SimulatedArm::new(info.obs_dim, Fault::None);
            let (mut behind, driver) = on_wall_clock(arm, 4 * period);
            let outcome = control(&mut behind, &spec, policy, &desired, limits);
            driver.join().map_err(|_| "the driver panicked")?;
            Ok(outcome?)
        }
        name => {
            let fault = name.map_or(Ok(Fault::None), Fault::named)?;
            let mut arm = SimulatedArm::new(info.obs_dim, fault);
            Ok(control(&mut arm, &spec, policy, &desired, limits)?)
        }
    }
}
