//! What the networks see: the normalised observation and the normalised goal, side by side.

use crate::config::GoalFrame;
use crate::goal::{Achieved, EncodedGoal, Position};
use crate::normalize::{CLIP, Normalizer};
use serde::{Deserialize, Serialize};

/// Turns an observation and an encoded goal into one row of network input.
///
/// The statistics of a slot only ever see real positions; a blank is filled in after normalising,
/// so that it stays an unmistakable flag.
///
/// # Shapes
///
/// `[observation ‖ 3 (N + 1)]` with absolute goals, `[observation ‖ 3 (N + 1) ‖ N + 1]` with
/// relative ones, whose blanks are told by a flag for each slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputEncoder {
    frame: GoalFrame,
    observation: Normalizer,
    slots: Vec<Normalizer>,
}

impl InputEncoder {
    /// An encoder without statistics, for goals of `objects` objects.
    pub fn new(frame: GoalFrame, observation: usize, objects: usize) -> Self {
        Self {
            frame,
            observation: Normalizer::new(observation),
            slots: vec![Normalizer::new(3); objects + 1],
        }
    }

    /// Numbers in a row.
    pub fn width(&self) -> usize {
        let flags = match self.frame {
            GoalFrame::Absolute => 0,
            GoalFrame::Relative => self.slots.len(),
        };
        self.observation.width() + 3 * self.slots.len() + flags
    }

    /// Numbers in a raw observation.
    pub fn observation(&self) -> usize {
        self.observation.width()
    }

    /// How many objects its goals have.
    pub fn objects(&self) -> usize {
        self.slots.len() - 1
    }

    /// How goals are encoded.
    pub fn frame(&self) -> GoalFrame {
        self.frame
    }

    /// Takes an observation into the statistics.
    pub fn observe(&mut self, observation: &[f32]) {
        self.observation.observe(observation);
    }

    /// Takes the slots of a goal that are not blank into the statistics.
    pub fn observe_goal<const N: usize>(&mut self, now: &Achieved<N>, goal: &EncodedGoal<N>) {
        let frame = self.frame;
        for ((slot, place), statistics) in goal.slots().zip(now.0.places()).zip(&mut self.slots) {
            if let Some(wanted) = slot {
                statistics.observe(&in_frame(frame, wanted, place));
            }
        }
    }

    /// Brings what was observed into force.
    pub fn refresh(&mut self) {
        self.observation.refresh();
        self.slots.iter_mut().for_each(Normalizer::refresh);
    }

    /// Writes the row for `observation` and `goal`, at a step where the scene is `now`.
    pub fn write<const N: usize>(
        &self,
        observation: &[f32],
        now: &Achieved<N>,
        goal: &EncodedGoal<N>,
        row: &mut [f32],
    ) {
        debug_assert_eq!(row.len(), self.width());
        let (head, tail) = row.split_at_mut(self.observation.width());
        self.observation.apply(observation, head);
        let (positions, flags) = tail.split_at_mut(3 * self.slots.len());
        let blank = match self.frame {
            GoalFrame::Absolute => -CLIP,
            GoalFrame::Relative => 0.0,
        };
        let slots = goal.slots().zip(now.0.places()).zip(&self.slots);
        for (((slot, place), statistics), out) in slots.zip(positions.chunks_exact_mut(3)) {
            match slot {
                Some(wanted) => statistics.apply(&in_frame(self.frame, wanted, place), out),
                None => out.fill(blank),
            }
        }
        for (flag, slot) in flags.iter_mut().zip(goal.slots()) {
            *flag = f32::from(u8::from(slot.is_none()));
        }
    }
}

#[inline]
fn in_frame(frame: GoalFrame, wanted: Position, place: Position) -> [f32; 3] {
    match frame {
        GoalFrame::Absolute => wanted.coords.into(),
        GoalFrame::Relative => (wanted - place).into(),
    }
}
