//! What an arm's driver delivers and takes, and a simulated arm that can be broken.

use rher_core::{Achieved, Position, Scene};
use std::time::Duration;

/// What the driver knows at one moment.
#[derive(Clone)]
pub(crate) struct Reading {
    /// When it was taken, on the arm's clock.
    pub(crate) taken: Duration,
    pub(crate) observation: Vec<f32>,
    pub(crate) scene: Achieved<1>,
}

/// An arm's driver.
pub(crate) trait Arm {
    /// Waits until `due` on the arm's clock; returns the time that it is then.
    fn wait_until(&mut self, due: Duration) -> Duration;
    /// The latest reading; `None` where none has arrived since the last call.
    fn read(&mut self) -> Option<Reading>;
    /// Carries out an action, each number in [−1, 1], until the next call.
    fn carry_out(&mut self, action: &[f32]);
    /// Keeps the pose until the next call.
    fn hold(&mut self);
    /// Ends the motion safely.
    fn stop(&mut self);
}

/// What goes wrong with a simulated arm, from its fifth reading on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    None,
    /// Readings arrive a second after they were taken.
    Late,
    /// The same reading arrives again and again.
    Frozen,
    /// One reading of three has NaN in it.
    Flickering,
    /// Every reading has NaN in it.
    Blinded,
    /// A number is missing in every reading.
    Rewired,
    /// The loop stalls for a second after its fifth reading, as when the computer was asleep.
    Stalled,
}

impl Fault {
    pub(crate) fn named(name: &str) -> Result<Self, String> {
        match name {
            "late" => Ok(Self::Late),
            "frozen" => Ok(Self::Frozen),
            "flickering" => Ok(Self::Flickering),
            "blinded" => Ok(Self::Blinded),
            "rewired" => Ok(Self::Rewired),
            "stalled" => Ok(Self::Stalled),
            _ => Err(format!(
                "the fault is `{name}`, expected late, frozen, flickering, blinded, rewired or \
                 stalled"
            )),
        }
    }
}

/// A hand that moves by a tenth of its action, beside a block that stays where it is. Its time is
/// simulated: nothing sleeps.
pub(crate) struct SimulatedArm {
    pub(crate) fault: Fault,
    pub(crate) readings: u32,
    /// Every action that was carried out.
    pub(crate) carried_out: Vec<Vec<f32>>,
    /// When each was.
    pub(crate) moments: Vec<Duration>,
    pub(crate) holds: u32,
    pub(crate) stopped: bool,
    obs_dim: usize,
    hand: Position,
    now: Duration,
    frozen: Duration,
}

impl SimulatedArm {
    pub(crate) fn new(obs_dim: usize, fault: Fault) -> Self {
        Self {
            fault,
            readings: 0,
            carried_out: Vec::new(),
            moments: Vec::new(),
            holds: 0,
            stopped: false,
            obs_dim,
            hand: Position::origin(),
            now: Duration::ZERO,
            frozen: Duration::ZERO,
        }
    }
}

impl Arm for SimulatedArm {
    fn wait_until(&mut self, due: Duration) -> Duration {
        self.now = self.now.max(due);
        if self.fault == Fault::Stalled && self.readings == 5 {
            self.now += Duration::from_secs(1);
        }
        self.now
    }

    fn read(&mut self) -> Option<Reading> {
        self.readings += 1;
        let scene = Achieved(Scene::new(self.hand, [Position::origin()]));
        let mut observation = vec![0.1; self.obs_dim];
        let mut taken = self.now;
        match self.fault {
            _ if self.readings < 5 => self.frozen = taken,
            Fault::None | Fault::Stalled => {}
            Fault::Late => taken = taken.saturating_sub(Duration::from_secs(1)),
            Fault::Frozen => taken = self.frozen,
            Fault::Flickering if !self.readings.is_multiple_of(3) => {}
            Fault::Flickering | Fault::Blinded => observation[0] = f32::NAN,
            Fault::Rewired => drop(observation.pop()),
        }
        Some(Reading { taken, observation, scene })
    }

    fn carry_out(&mut self, action: &[f32]) {
        let moves = self.hand.iter_mut().zip(action);
        moves.for_each(|(place, number)| *place += 0.1 * number);
        self.carried_out.push(action.to_vec());
        self.moments.push(self.now);
    }

    fn hold(&mut self) {
        self.holds += 1;
    }

    fn stop(&mut self) {
        self.stopped = true;
    }
}
