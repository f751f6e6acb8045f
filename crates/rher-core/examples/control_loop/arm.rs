//! What an arm's driver delivers and takes, and a simulated arm that can be broken.

use rher_core::{Achieved, Position, Scene};
use std::time::{Duration, Instant};

/// What the driver knows at one moment.
pub(crate) struct Reading {
    pub(crate) taken: Instant,
    pub(crate) observation: Vec<f32>,
    pub(crate) scene: Achieved<1>,
}

/// An arm's driver.
pub(crate) trait Arm {
    fn read(&mut self) -> Reading;
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
}

impl Fault {
    pub(crate) fn named(name: &str) -> Result<Self, String> {
        match name {
            "late" => Ok(Self::Late),
            "frozen" => Ok(Self::Frozen),
            "flickering" => Ok(Self::Flickering),
            "blinded" => Ok(Self::Blinded),
            "rewired" => Ok(Self::Rewired),
            _ => Err(format!(
                "the fault is `{name}`, expected late, frozen, flickering, blinded or rewired"
            )),
        }
    }
}

/// A hand that moves by a tenth of its action, beside a block that stays where it is.
pub(crate) struct SimulatedArm {
    pub(crate) fault: Fault,
    pub(crate) readings: u32,
    /// Every action that was carried out.
    pub(crate) carried_out: Vec<Vec<f32>>,
    pub(crate) holds: u32,
    pub(crate) stopped: bool,
    obs_dim: usize,
    hand: Position,
    frozen: Instant,
}

impl SimulatedArm {
    pub(crate) fn new(obs_dim: usize, fault: Fault) -> Self {
        Self {
            fault,
            readings: 0,
            carried_out: Vec::new(),
            holds: 0,
            stopped: false,
            obs_dim,
            hand: Position::origin(),
            frozen: Instant::now(),
        }
    }
}

impl Arm for SimulatedArm {
    fn read(&mut self) -> Reading {
        self.readings += 1;
        let scene = Achieved(Scene { gripper: self.hand, objects: [Position::origin()] });
        let mut observation = vec![0.1; self.obs_dim];
        let mut taken = Instant::now();
        match self.fault {
            _ if self.readings < 5 => self.frozen = taken,
            Fault::None => {}
            Fault::Late => taken -= Duration::from_secs(1),
            Fault::Frozen => taken = self.frozen,
            Fault::Flickering if !self.readings.is_multiple_of(3) => {}
            Fault::Flickering | Fault::Blinded => observation[0] = f32::NAN,
            Fault::Rewired => drop(observation.pop()),
        }
        Reading { taken, observation, scene }
    }

    fn carry_out(&mut self, action: &[f32]) {
        let moves = self.hand.iter_mut().zip(action);
        moves.for_each(|(place, number)| *place += 0.1 * number);
        self.carried_out.push(action.to_vec());
    }

    fn hold(&mut self) {
        self.holds += 1;
    }

    fn stop(&mut self) {
        self.stopped = true;
    }
}
