//! What makes an order of objects easy or hard: the way through the scene, and what is beside it.

use crate::goal::{Achieved, Desired, Position};
use nalgebra::distance;

/// How many numbers [`features`] has for `objects` objects.
pub(super) fn count(objects: usize) -> usize {
    2 * (2 * objects + 3 * objects * objects.saturating_sub(1))
}

/// A place in a scene where an episode begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Point {
    /// The gripper's.
    Gripper,
    /// Where this object is.
    Start(usize),
    /// Where this object should be.
    Target(usize),
}

/// A distance that matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// From one point to another.
    Between(Point, Point),
    /// From the straight line between two points to a third one.
    ToLine { start: Point, end: Point, point: Point },
}

/// The distances that matter when the objects are brought to their targets in the order `order`.
///
/// These are the legs of the way (from the gripper to the first object, from there to its target,
/// from there to the second object, and so on), and for every pair of objects what may be in the
/// way: from object to object, from target to target, from an object to another's target, and from
/// the straight line that an object takes to where another one is at that time.
pub(crate) fn ways(order: &[usize]) -> impl Iterator<Item = Way> {
    let legs = order.iter().scan(Point::Gripper, |hand, &object| {
        let (start, end) = (Point::Start(object), Point::Target(object));
        Some([Way::Between(std::mem::replace(hand, end), start), Way::Between(start, end)])
    });
    let pairs = (0..order.len()).flat_map(move |this| {
        let others = (0..order.len()).filter(move |other| *other != this);
        others.flat_map(move |other| {
            let [start, end] = [Point::Start, Point::Target].map(|at| at(order[this]));
            let [others_start, others_end] =
                [Point::Start, Point::Target].map(|at| at(order[other]));
            let point = if other > this { others_start } else { others_end };
            let beside = [Way::Between(start, others_end), Way::ToLine { start, end, point }];
            let once = [Way::Between(start, others_start), Way::Between(end, others_end)];
            beside.into_iter().chain(once.into_iter().filter(move |_| other > this))
        })
    });
    legs.flatten().chain(pairs)
}

/// The [`ways`] of an order, each in meters and once more as its nearness,
/// 1 / (1 + (distance / `tolerance`)²).
pub(super) fn features<const N: usize>(
    start: &Achieved<N>,
    desired: &Desired<N>,
    order: &[usize],
    tolerance: f32,
) -> Vec<f64> {
    let at = |point: Point| match point {
        Point::Gripper => start.0.gripper,
        Point::Start(object) => start.0.objects[object],
        Point::Target(object) => desired.objects()[object],
    };
    let distances = ways(order).map(|way| match way {
        Way::Between(start, end) => distance(&at(start), &at(end)),
        Way::ToLine { start, end, point } => distance_to_line(&at(start), &at(end), &at(point)),
    });
    let nearness = |distance: f32| {
        let tolerances = f64::from(distance / tolerance);
        1.0 / (1.0 + tolerances * tolerances)
    };
    let both = distances.flat_map(|distance| [f64::from(distance), nearness(distance)]);
    both.collect()
}

/// From `point` to the nearest point of the straight line between two others.
fn distance_to_line(start: &Position, end: &Position, point: &Position) -> f32 {
    let (line, reach) = (end - start, point - start);
    let squared_length = line.norm_squared();
    let share = if squared_length > 0.0 { line.dot(&reach) / squared_length } else { 0.0 };
    (reach - line * share.clamp(0.0, 1.0)).norm()
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these distances have no rounding errors")]
mod tests {
    use super::*;
    use crate::goal::Scene;

    #[test]
    fn a_line_is_as_far_as_its_nearest_point() {
        let at = |x, y| Position::new(x, y, 0.0);
        let far = |point| distance_to_line(&at(0.0, 0.0), &at(2.0, 0.0), &point);
        assert_eq!([far(at(1.0, 0.5)), far(at(3.0, 0.0)), far(at(-3.0, 4.0))], [0.5, 1.0, 5.0]);
        assert_eq!(distance_to_line(&at(1.0, 1.0), &at(1.0, 1.0), &at(1.0, 3.0)), 2.0);
    }

    #[test]
    fn every_order_of_a_scene_has_its_distances() {
        let at = |x| Position::new(x, 0.0, 0.0);
        let start = Achieved(Scene::new(at(0.0), [at(1.0), at(3.0)]));
        let desired = Desired::of_task([at(2.0), at(7.0)]);
        let meters = |order: &[usize]| -> Vec<f64> {
            let both = features(&start, &desired, order, 1.0);
            assert_eq!(both.len(), count(2));
            assert_eq!(both[1], 1.0 / (1.0 + both[0] * both[0]));
            both.into_iter().step_by(2).collect()
        };
        // The legs; from the first's start to the second's target, from the first's line to the
        // second's start, from start to start, from target to target; the same for the second.
        assert_eq!(meters(&[0, 1]), [1.0, 1.0, 1.0, 4.0, 6.0, 1.0, 2.0, 5.0, 1.0, 1.0]);
        assert_eq!(meters(&[1, 0]), [3.0, 4.0, 6.0, 1.0, 1.0, 2.0, 2.0, 5.0, 6.0, 5.0]);
    }
}
