//! Distances on a second, finer scale, beside those in units of their standard deviation.

use crate::goal::{Achieved, EncodedGoal, TailSpec, Tolerances, unit};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::iter;

/// Differences are clipped to ± this many tolerances.
pub(crate) const NEAR: f32 = 2.0;

/// Distances are clipped to this many tolerances.
pub(crate) const FAR: f32 = 3.0;

/// What networks see of a scene in units of the tolerance, clipped to what is near.
///
/// A standard deviation is about a decimeter, so that a hand behind a block and one beside it are
/// nearly the same input, and so are a block within the tolerance of its target and one that is
/// not. On this scale they differ by all that there is.
///
/// # Shape
///
/// `[4 (N + 1) + 3 N + 3 (N − 1) + P N]`: for each slot of the goal, the gripper's first, the difference
/// to the goal (3) and its length beyond the tolerance (1), all 0 in a blank; for each object its
/// difference to the gripper (3); for each object but the first its difference to the first (3); for
/// each object and each of the P parts of its tail, how far beyond the tolerance it is (1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FineScale {
    /// In meters, by slot.
    pub(crate) tolerances: Vec<f32>,
}

impl FineScale {
    /// For goals with these tolerances.
    pub(super) fn new<const N: usize>(tolerances: &Tolerances<N>) -> Self {
        Self { tolerances: tolerances.by_slot().map(unit).collect() }
    }

    /// Whether it fits goals with so many objects; that of a damaged file may not.
    pub(super) fn fits(&self, objects: usize) -> bool {
        let is_unit = |tolerance: &f32| tolerance.is_finite() && *tolerance > 0.0;
        self.tolerances.len() == objects + 1 && self.tolerances.iter().all(is_unit)
    }

    /// Numbers that it writes.
    pub(super) fn width(&self, tail: &TailSpec) -> usize {
        // 4 (N + 1) + 3 N + 3 (N − 1), for N + 1 tolerances; a damaged file may have none.
        let positions = (10 * self.tolerances.len()).saturating_sub(9);
        positions + tail.parts().len() * self.tolerances.len().saturating_sub(1)
    }

    /// What each of the numbers is, in scenes with these objects.
    #[cfg(feature = "train")]
    pub(super) fn names(objects: &[String], parts: &[String]) -> Vec<String> {
        let slots = iter::once("gripper").chain(objects.iter().map(String::as_str));
        let of_slot =
            |slot| ["x", "y", "z", "distance"].map(|what| format!("near.goal.{slot}.{what}"));
        let from = |object: &str, other: &str| {
            ["x", "y", "z"].map(|axis| format!("near.{object}.from_{other}.{axis}"))
        };
        let from_gripper = objects.iter().flat_map(|object| from(object, "gripper"));
        let others = objects.iter().skip(1);
        let from_first = others.flat_map(|object| from(object, &objects[0]));
        let of_tail = objects.iter().flat_map(|object| {
            parts.iter().map(move |part| format!("near.goal.{object}.{part}.distance"))
        });
        slots.flat_map(of_slot).chain(from_gripper).chain(from_first).chain(of_tail).collect()
    }

    /// Writes what it sees of `goal` at a step where the scene is `now`, the objects in `order`.
    pub(super) fn write<const N: usize>(
        &self,
        now: &Achieved<N>,
        goal: &EncodedGoal<N>,
        tail: &TailSpec,
        order: [usize; N],
        out: &mut [f32],
    ) {
        let (slots, others) = out.split_at_mut(4 * self.tolerances.len());
        let (positions, tails) = others.split_at_mut(6 * N - 3);
        let of_gripper = (goal.gripper(), now.0.gripper, self.tolerances[0]);
        let objects = order.map(|object| (now.0.objects[object], self.tolerances[object + 1]));
        let of_objects = iter::zip(order, objects)
            .map(|(object, (place, tolerance))| (goal.objects()[object], place, tolerance));
        for (out, (slot, place, tolerance)) in
            slots.chunks_exact_mut(4).zip(iter::once(of_gripper).chain(of_objects))
        {
            let Some(wanted) = slot else {
                out.fill(0.0);
                continue;
            };
            let difference = (wanted - place) / tolerance;
            out[..3].copy_from_slice(near(difference).as_slice());
            out[3] = difference.norm().min(FAR) - 1.0;
        }
        let from_gripper = objects.iter().map(|(place, unit)| (place - now.0.gripper) / *unit);
        let (first, _) = objects[0];
        let from_first = objects[1..].iter().map(|(place, unit)| (place - first) / *unit);
        for (out, difference) in positions.chunks_exact_mut(3).zip(from_gripper.chain(from_first)) {
            out.copy_from_slice(near(difference).as_slice());
        }
        if tail.is_none() {
            return;
        }
        for (object, out) in iter::zip(order, tails.chunks_exact_mut(tail.parts().len())) {
            if goal.objects()[object].is_none() {
                out.fill(0.0);
                continue;
            }
            let far = tail.in_tolerances(goal.tail(object), now.0.tails.of_object(object));
            for (out, far) in out.iter_mut().zip(far) {
                *out = far.min(FAR) - 1.0;
            }
        }
    }
}

fn near(difference: Vector3<f32>) -> Vector3<f32> {
    difference.map(|number| number.clamp(-NEAR, NEAR))
}
