//! What the networks see: the normalized observation and the normalized goal, side by side.

use super::fine_scale::FineScale;
use super::normalize::{CLIP, Normalizer};
use super::order::OrderModel;
use super::turns::{self, Turns};
use crate::config::{GoalFrame, ObjectOrder, RelayConfig};
use crate::env::EnvSpec;
use crate::goal::{Achieved, EncodedGoal, Position, TAIL_INPUTS, Tail, TailSpec};
#[cfg(feature = "train")]
use crate::names::Names;
use serde::{Deserialize, Serialize};
use std::iter;

/// Turns an observation and an encoded goal into one row of network input.
///
/// The statistics of a slot only ever see real positions; a blank is filled in after normalizing,
/// so that it stays an unmistakable flag.
///
/// # Shapes
///
/// `[observation ‖ 3 (N + 1)]` with absolute goals, `[observation ‖ 3 (N + 1) ‖ N + 1]` with
/// relative ones, whose blanks are told by a flag for each slot. Where goals are more than positions,
/// the three numbers of an object's slot are followed by those of its tail. With
/// [`fine_scale`](RelayConfig::fine_scale) the near distances come after these. With
/// [`ObjectOrder::Turn`] the objects come in the order of their turns, in all of it.
// What a newer version adds is not left out by reading past it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputEncoder {
    pub(crate) frame: GoalFrame,
    pub(crate) observation: Normalizer,
    pub(crate) slots: Vec<Normalizer>,
    /// What the slots of objects hold beside positions.
    #[serde(default, with = "crate::since_6", skip_serializing_if = "TailSpec::is_none")]
    pub(crate) tail: TailSpec,
    #[serde(default)]
    pub(crate) turns: Option<Turns>,
    #[serde(default, with = "crate::since_6")]
    pub(crate) fine_scale: Option<FineScale>,
    /// Which order of the objects is taken, where it has been learned.
    #[serde(default, with = "crate::since_6")]
    pub(crate) order: Option<OrderModel>,
}

impl InputEncoder {
    /// An encoder without statistics, for environments like `spec`.
    pub fn new<const N: usize>(config: &RelayConfig, spec: &EnvSpec<N>) -> Self {
        let tolerances = config.tolerances(spec);
        let turns =
            (config.object_order == ObjectOrder::Turn).then(|| Turns::new(spec, &tolerances));
        Self {
            frame: config.goal_frame,
            observation: Normalizer::new(spec.obs_dim),
            slots: (0..=N).map(|slot| Normalizer::new(width(slot, &tolerances.tail))).collect(),
            tail: tolerances.tail,
            turns: turns.flatten(),
            fine_scale: config.fine_scale.then(|| FineScale::new(&tolerances)),
            order: None,
        }
    }

    /// Which order of the objects promises most, where it has been learned.
    pub(crate) fn order(&self) -> Option<&OrderModel> {
        self.order.as_ref()
    }

    /// Has the order of the objects chosen by `order`, or left as it is given.
    #[cfg(feature = "train")]
    pub(crate) fn set_order(&mut self, order: Option<OrderModel>) {
        self.order = order;
    }

    /// Numbers in a row.
    pub fn width(&self) -> usize {
        let fine_scale = self.fine_scale.as_ref().map_or(0, |it| it.width(&self.tail));
        self.observation.width() + self.goal() + self.flags() + fine_scale
    }

    /// Numbers in all slots.
    fn goal(&self) -> usize {
        3 * self.slots.len() + self.tail.inputs() * self.objects()
    }

    /// What the slots of objects hold beside positions.
    pub(crate) fn tail(&self) -> &TailSpec {
        &self.tail
    }

    /// Slots whose blanks are told by a flag.
    fn flags(&self) -> usize {
        match self.frame {
            GoalFrame::Absolute => 0,
            GoalFrame::Relative => self.slots.len(),
        }
    }

    /// One name for each number in a row, in environments with these names.
    ///
    /// What a run takes over from that of another task follows from this list alone.
    #[cfg(feature = "train")]
    pub(crate) fn names(&self, names: &Names) -> Vec<String> {
        let slots = || iter::once("gripper").chain(names.objects.iter().map(String::as_str));
        let of_slot = |slot| ["x", "y", "z"].map(|axis| format!("goal.{slot}.{axis}"));
        let mut list = names.observation.clone();
        list.extend(of_slot("gripper"));
        for object in &names.objects {
            list.extend(of_slot(object));
            let inputs = self.tail.input_names(&names.tail);
            list.extend(inputs.iter().map(|input| format!("goal.{object}.{input}")));
        }
        list.extend(slots().take(self.flags()).map(|slot| format!("goal.{slot}.blank")));
        if self.fine_scale.is_some() {
            list.extend(FineScale::names(&names.objects, &names.tail));
        }
        debug_assert_eq!(list.len(), self.width());
        list
    }

    /// Takes over the statistics of an encoder for fewer objects: those of an observation from the
    /// numbers at these places, those of a slot that it does not have from its first object's.
    #[cfg(feature = "train")]
    pub(crate) fn inherit(&mut self, known: &Self, observation: &[Option<usize>]) {
        self.observation = known.observation.rearranged(observation);
        for (index, slot) in self.slots.iter_mut().enumerate() {
            if let Some(known) = known.slots.get(index).or(known.slots.get(1)) {
                slot.clone_from(known);
            }
        }
    }

    /// Numbers in a raw observation.
    pub fn observation(&self) -> usize {
        self.observation.width()
    }

    /// How many objects its goals have.
    pub fn objects(&self) -> usize {
        self.slots.len().saturating_sub(1)
    }

    /// Whether its parts fit each other, which those of a damaged file may not.
    pub(crate) fn check(&self) -> Result<(), String> {
        let wrong = |what: &str| Err(format!("the statistics of {what} do not fit each other"));
        if !self.observation.is_consistent(self.observation.width()) {
            return wrong("its observations");
        }
        let mut slots = self.slots.iter().enumerate();
        if !slots.all(|(slot, statistics)| statistics.is_consistent(width(slot, &self.tail))) {
            return wrong("its goals");
        }
        if !self.turns.as_ref().is_none_or(|it| it.fits(self.observation(), self.objects())) {
            return Err("the order of its objects does not fit its observation".to_owned());
        }
        if !self.fine_scale.as_ref().is_none_or(|it| it.fits(self.objects())) {
            return Err("the tolerances of its fine scale do not fit its goals".to_owned());
        }
        if !self.order.as_ref().is_none_or(|it| it.fits(self.observation(), self.objects())) {
            return Err("the choice of an order does not fit its objects".to_owned());
        }
        Ok(())
    }

    /// How goals are encoded.
    pub fn frame(&self) -> GoalFrame {
        self.frame
    }

    /// Takes an observation into the statistics.
    pub fn observe(&mut self, observation: &[f32]) {
        match &self.turns {
            None => self.observation.observe(observation.iter().copied()),
            Some(turns) => {
                for first in 0..turns.objects() {
                    self.observation.observe(turns.observation(first, observation));
                }
            }
        }
    }

    /// Takes the slots of a goal that are not blank into the statistics.
    pub fn observe_goal<const N: usize>(&mut self, now: &Achieved<N>, goal: &EncodedGoal<N>) {
        let mut staying = None;
        let goal = self.seen(now, goal, &mut staying);
        for (index, (slot, place)) in goal.slots().zip(now.0.places()).enumerate() {
            let alike = match self.turns {
                Some(_) if index > 0 => 1..N + 1,
                _ => index..index + 1,
            };
            if let Some(wanted) = slot {
                let seen = in_frame(self.frame, wanted, place);
                match index.checked_sub(1).filter(|_| !self.tail.is_none()) {
                    None => {
                        for statistics in &mut self.slots[alike] {
                            statistics.observe(seen);
                        }
                    }
                    Some(object) => {
                        let mut tail = [0.0; TAIL_INPUTS];
                        let reached = now.0.tails.of_object(object);
                        self.write_tail(goal.tail(object), reached, &mut tail);
                        for statistics in &mut self.slots[alike] {
                            statistics.observe(seen.into_iter().chain(tail));
                        }
                    }
                }
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
        let mut staying = None;
        let goal = self.seen(now, goal, &mut staying);
        let (head, tail) = row.split_at_mut(self.observation.width());
        let first = match &self.turns {
            None => {
                self.observation.apply(observation.iter().copied(), head);
                0
            }
            Some(turns) => {
                let first = turns.first(now, goal, &self.tail);
                self.observation.apply(turns.observation(first, observation), head);
                first
            }
        };
        let (mut slots_out, tail) = tail.split_at_mut(self.goal());
        let (flags, near) = tail.split_at_mut(self.flags());
        let blank = match self.frame {
            GoalFrame::Absolute => -CLIP,
            GoalFrame::Relative => 0.0,
        };
        let order = turns::order::<N>(first);
        if let Some(fine_scale) = &self.fine_scale {
            fine_scale.write(now, goal, &self.tail, order, near);
        }
        let in_turn = order.map(|object| {
            let tails = (goal.tail(object), now.0.tails.of_object(object));
            (goal.objects()[object], now.0.objects[object], Some(tails))
        });
        let slots = iter::once((goal.gripper(), now.0.gripper, None)).chain(in_turn);
        for (index, (slot, place, tails)) in slots.enumerate() {
            let statistics = &self.slots[index];
            let (out, others) = slots_out.split_at_mut(statistics.width());
            slots_out = others;
            match (slot, tails) {
                (None, _) => out.fill(blank),
                (Some(wanted), Some((tail, reached))) if !self.tail.is_none() => {
                    let mut inputs = [0.0; TAIL_INPUTS];
                    self.write_tail(tail, reached, &mut inputs);
                    let seen = in_frame(self.frame, wanted, place).into_iter().chain(inputs);
                    statistics.apply(seen, out);
                }
                (Some(wanted), _) => statistics.apply(in_frame(self.frame, wanted, place), out),
            }
            if let Some(flag) = flags.get_mut(index) {
                *flag = f32::from(u8::from(slot.is_none()));
            }
        }
    }

    /// The goal as the networks see it: where goals have no positions, objects stay where they are,
    /// in a copy that is put into `staying`.
    #[inline]
    fn seen<'a, const N: usize>(
        &self,
        now: &Achieved<N>,
        goal: &'a EncodedGoal<N>,
        staying: &'a mut Option<EncodedGoal<N>>,
    ) -> &'a EncodedGoal<N> {
        if self.tail.has_positions() { goal } else { staying.insert(goal.staying(now)) }
    }

    /// Writes what the networks see of a tail that is wanted, before it is normalized.
    fn write_tail(&self, wanted: &Tail, reached: &Tail, inputs: &mut [f32]) {
        match self.frame {
            GoalFrame::Absolute => self.tail.encode(wanted, None, inputs),
            GoalFrame::Relative => self.tail.encode(wanted, Some(reached), inputs),
        }
    }
}

/// Numbers of a slot: a position, and what else goals say of an object.
fn width(slot: usize, tail: &TailSpec) -> usize {
    if slot == 0 { 3 } else { 3 + tail.inputs() }
}

#[inline]
fn in_frame(frame: GoalFrame, wanted: Position, place: Position) -> [f32; 3] {
    match frame {
        GoalFrame::Absolute => wanted.coords.into(),
        GoalFrame::Relative => (wanted - place).into(),
    }
}
