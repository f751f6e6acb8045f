//! Why an episode failed.

use rher_core::episode::Episode;
use rher_core::goal::{Achieved, EncodedGoal, Leg, Position, Stage, Tolerances};
use rher_core::nalgebra::distance;
use serde::Serialize;
use std::fmt;
use std::ops::AddAssign;

/// How much lower than its goal an object is that has been dropped, in meters: blocks of a tower are
/// 5 cm apart.
const LOWER: f32 = 0.02;

/// How far an object has fallen that has been dropped, in meters.
const FALLEN: f32 = 0.03;

/// How far the gripper is from an object that it does not hold, in meters.
const LET_GO: f32 = 0.05;

/// Frames for which something is in its place that lies there.
const LYING: usize = 5;

/// How far what lies or stands moves at most, in meters.
const STILL: f32 = 0.01;

/// The share of an episode for which nothing moves that is stuck.
const LAST_PART: usize = 5;

/// The kinds of failures. An episode that failed is of the first kind that is true of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// An object that is not in its place is at least 2 cm lower than its goal, was at least 3 cm
    /// higher before, and is more than 5 cm from the gripper: it fell off the table, from the hand or
    /// from a tower.
    Dropped,
    /// What is not in its place at the end had been lying in it: for five frames, in which it moved
    /// less than 1 cm.
    Disturbed,
    /// An object that is not in its place lies, or has its goal, where actions cannot bring the
    /// gripper.
    OutOfReach,
    /// Neither the gripper nor an object was more than 1 cm from where it ended in the last fifth of
    /// the episode.
    Stuck,
    /// Something still moved.
    Late,
}

impl Failure {
    /// Why the sub-task that ends with `stage` failed; `None` if it succeeded. `can_reach` says
    /// whether actions can bring the gripper to a place.
    pub(crate) fn of<const N: usize>(
        stage: Stage<N>,
        episode: &Episode<N>,
        tolerances: &Tolerances<N>,
        can_reach: impl Fn(&Position) -> bool,
    ) -> Option<Self> {
        let end = episode.achieved.last()?;
        if EncodedGoal::new(stage, end, &episode.desired).is_met(end, tolerances) {
            return None;
        }
        let targets = episode.desired.objects();
        // A sub-task that reaches an object is about the gripper as well.
        let placed = stage.object() + usize::from(stage.leg() == Leg::Place);
        let out_of_place = |object: &usize| !tolerances.placed(*object, end, &episode.desired);
        let objects: Vec<usize> = (0..placed).filter(out_of_place).collect();

        let frames = &episode.achieved;
        let is_dropped = |object: &usize| is_dropped(*object, frames, &targets[*object]);
        let was_there = |object: &usize| {
            let is_there = |now: &Achieved<N>| tolerances.placed(*object, now, &episode.desired);
            has_lain(*object, frames, is_there)
        };
        let is_away =
            |object: &usize| !can_reach(&end.0.objects[*object]) || !can_reach(&targets[*object]);
        Some(match () {
            () if objects.iter().any(is_dropped) => Self::Dropped,
            () if objects.iter().any(was_there) => Self::Disturbed,
            () if objects.iter().any(is_away) => Self::OutOfReach,
            () if stands_still(frames) => Self::Stuck,
            () => Self::Late,
        })
    }
}

fn is_dropped<const N: usize>(object: usize, frames: &[Achieved<N>], target: &Position) -> bool {
    let Some(Achieved(end)) = frames.last() else { return false };
    let place = end.objects[object];
    let highest = frames.iter().map(|frame| frame.0.objects[object].z).fold(place.z, f32::max);
    target.z - place.z >= LOWER
        && highest - place.z >= FALLEN
        && distance(&place, &end.gripper) > LET_GO
}

/// Whether an object was in its place for a while without moving.
fn has_lain<const N: usize>(
    object: usize,
    frames: &[Achieved<N>],
    is_there: impl Fn(&Achieved<N>) -> bool,
) -> bool {
    frames.windows(LYING).any(|part| {
        let start = &part[0].0.objects[object];
        let is_still = |now: &Achieved<N>| distance(&now.0.objects[object], start) < STILL;
        part.iter().all(|now| is_there(now) && is_still(now))
    })
}

/// Whether nothing moves in the last part of an episode.
fn stands_still<const N: usize>(frames: &[Achieved<N>]) -> bool {
    let Some(Achieved(end)) = frames.last() else { return true };
    let steps = frames.len() - 1;
    frames[steps - steps / LAST_PART..].iter().all(|Achieved(scene)| {
        scene.places().zip(end.places()).all(|(now, then)| distance(&now, &then) < STILL)
    })
}

/// How many episodes failed in each way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Failures {
    dropped: usize,
    disturbed: usize,
    out_of_reach: usize,
    stuck: usize,
    late: usize,
}

impl AddAssign<Failure> for Failures {
    fn add_assign(&mut self, failure: Failure) {
        *match failure {
            Failure::Dropped => &mut self.dropped,
            Failure::Disturbed => &mut self.disturbed,
            Failure::OutOfReach => &mut self.out_of_reach,
            Failure::Stuck => &mut self.stuck,
            Failure::Late => &mut self.late,
        } += 1;
    }
}

/// `3 stuck, 1 late`, or `none`.
impl fmt::Display for Failures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dropped, disturbed, out_of_reach, stuck, late } = *self;
        let kinds = [
            (dropped, "dropped"),
            (disturbed, "disturbed"),
            (out_of_reach, "out of reach"),
            (stuck, "stuck"),
            (late, "late"),
        ];
        let there = kinds.iter().filter(|(count, _)| *count > 0);
        let there: Vec<String> = there.map(|(count, kind)| format!("{count} {kind}")).collect();
        f.write_str(if there.is_empty() { "none".to_owned() } else { there.join(", ") }.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rher_core::env::End;
    use rher_core::goal::{Desired, Scene};

    const TARGET: Position = Position::new(0.3, 0.0, 0.1);

    /// An episode of twenty steps with a block and a gripper that go from each place to the next,
    /// at even speed.
    fn episode(block: &[Position], gripper: &[Position]) -> Episode<1> {
        let along = |path: &[Position], step: usize| {
            let at = step as f32 / 20.0 * (path.len() - 1) as f32;
            let from = (at as usize).min(path.len().saturating_sub(2));
            let to = path[(from + 1).min(path.len() - 1)];
            path[from] + (to - path[from]) * (at - from as f32)
        };
        let frame = |step| Scene::new(along(gripper, step), [along(block, step)]);
        Episode {
            desired: Desired::of_task([TARGET]),
            observations: Vec::new(),
            achieved: (0..=20).map(frame).map(Achieved).collect(),
            actions: Vec::new(),
            end: End::Truncated,
        }
    }

    fn failure(block: &[Position], gripper: &[Position]) -> Option<Failure> {
        let stage = Stage::place(0);
        let tolerances = Tolerances::uniform(0.05);
        Failure::of(stage, &episode(block, gripper), &tolerances, |place| place.x < 1.0)
    }

    fn at(x: f32, z: f32) -> Position {
        Position::new(x, 0.0, z)
    }

    #[test]
    fn what_is_in_its_place_has_not_failed() {
        assert_eq!(failure(&[at(0.0, 0.0), TARGET], &[TARGET]), None);
    }

    #[test]
    fn what_fell_is_dropped_but_not_what_the_hand_lowers() {
        let path = [at(0.0, 0.0), at(0.1, 0.05), at(0.2, 0.0)];
        assert_eq!(failure(&path, &[at(0.1, 0.1)]), Some(Failure::Dropped));
        assert_eq!(failure(&path, &path), Some(Failure::Late));
        // Off the table.
        let path = [at(0.0, 0.1), at(0.5, 0.1), at(0.6, -0.3)];
        assert_eq!(failure(&path, &[at(0.5, 0.1)]), Some(Failure::Dropped));
        // It slid down by less than 3 cm, and was carried no higher than its goal.
        let path = [at(0.0, 0.02), at(0.2, 0.0)];
        assert_eq!(failure(&path, &[at(0.0, 0.1)]), Some(Failure::Late));
    }

    #[test]
    fn what_lay_in_its_place_was_disturbed_but_not_what_passed() {
        let lay = [at(0.0, 0.1), TARGET, TARGET, at(0.5, 0.1)];
        assert_eq!(failure(&lay, &[at(0.4, 0.1)]), Some(Failure::Disturbed));
        let passed = [at(0.0, 0.1), at(0.6, 0.1)];
        assert_eq!(failure(&passed, &[at(0.4, 0.1)]), Some(Failure::Late));
    }

    #[test]
    fn what_the_hand_cannot_get_at_is_out_of_reach() {
        let away = [at(0.0, 0.1), at(1.2, 0.1)];
        assert_eq!(failure(&away, &[at(0.5, 0.1)]), Some(Failure::OutOfReach));
    }

    #[test]
    fn what_does_not_move_any_more_is_stuck() {
        let touched = [at(0.0, 0.1), at(0.1, 0.1), at(0.1, 0.1), at(0.1, 0.1)];
        assert_eq!(failure(&touched, &[at(0.0, 0.1)]), Some(Failure::Stuck));
        let hand = [at(0.0, 0.1), at(0.3, 0.1)];
        assert_eq!(failure(&touched, &hand), Some(Failure::Late));
    }

    #[test]
    fn a_hand_that_should_reach_something_is_stuck_or_late() {
        let reach = Stage::FIRST;
        let of = |gripper: &[Position]| {
            let tolerances = Tolerances::uniform(0.05);
            Failure::of(reach, &episode(&[at(0.9, 0.1)], gripper), &tolerances, |_| true)
        };
        assert_eq!(of(&[at(0.0, 0.1)]), Some(Failure::Stuck));
        assert_eq!(of(&[at(0.0, 0.1), at(0.5, 0.1)]), Some(Failure::Late));
        assert_eq!(of(&[at(0.0, 0.1), at(0.9, 0.1)]), None);
    }

    #[test]
    fn failures_are_counted_by_kind() {
        let mut failures = Failures::default();
        assert_eq!(failures.to_string(), "none");
        for failure in [Failure::Late, Failure::OutOfReach, Failure::Late] {
            failures += failure;
        }
        assert_eq!(failures.to_string(), "1 out of reach, 2 late");
    }
}
