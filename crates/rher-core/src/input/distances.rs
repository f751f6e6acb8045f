//! What makes an order of objects easy or hard: the way through the scene, and what is beside it.

use crate::goal::{Achieved, Desired, Position};
use nalgebra::distance;

/// How many numbers [`features`] has for `objects` objects.
pub(super) fn count(objects: usize) -> usize {
    2 * (2 * objects + 3 * objects * objects.saturating_sub(1))
}

/// The distances that matter when the objects are brought to their targets in the order `order`,
/// each in meters and once more as its nearness, 1 / (1 + (distance / `tolerance`)²).
///
/// These are the legs of the way (from the gripper to the first object, from there to its target,
/// from there to the second object, and so on), and for every pair of objects what may be in the
/// way: from object to object, from target to target, from an object to another's target, and from
/// the straight line that an object takes to where another one is at that time.
pub(super) fn features<const N: usize>(
    start: &Achieved<N>,
    desired: &Desired<N>,
    order: &[usize],
    tolerance: f32,
) -> Vec<f64> {
    let from: Vec<Position> = order.iter().map(|&object| start.0.objects[object]).collect();
    let to: Vec<Position> = order.iter().map(|&object| desired.objects()[object]).collect();
    let mut distances = Vec::with_capacity(count(N) / 2);
    let mut hand = start.0.gripper;
    for (from, to) in from.iter().zip(&to) {
        distances.extend([distance(&hand, from), distance(from, to)]);
        hand = *to;
    }
    for this in 0..order.len() {
        for other in (0..order.len()).filter(|other| *other != this) {
            let others_place = if other > this { from[other] } else { to[other] };
            distances.push(distance(&from[this], &to[other]));
            distances.push(distance_to_line(&from[this], &to[this], &others_place));
            if other > this {
                distances.push(distance(&from[this], &from[other]));
                distances.push(distance(&to[this], &to[other]));
            }
        }
    }
    let nearness = |distance: f32| {
        let tolerances = f64::from(distance / tolerance);
        1.0 / (1.0 + tolerances * tolerances)
    };
    let both = distances.iter().flat_map(|&distance| [f64::from(distance), nearness(distance)]);
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
