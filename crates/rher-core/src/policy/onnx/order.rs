//! The choice of an order of the objects, as operators: [`OrderModel::choose`].

use super::graph::{Attribute, Graph, Value, whole};
use super::inputs::Scene;
use super::proto::DataType;
use crate::input::{OrderModel, Point, Way, ways};
use std::iter;

/// Which of the orders promises most where an episode begins, `[B]`: 0 is the given one, and the
/// others follow as in the model.
pub(super) fn choice<'g>(
    graph: &'g Graph,
    model: &OrderModel,
    objects: usize,
    begun: Scene<'g>,
    targets: Value<'g>,
) -> Value<'g> {
    let points = graph.joined(&[begun.gripper, begun.objects, targets], 1);
    let given: Vec<usize> = (0..objects).collect();
    let orders = iter::once(&given).chain(model.others.iter().map(|other| &other.order));
    let ways: Vec<Vec<Way>> = orders.map(|order| ways(order).collect()).collect();

    // Distances between two points, and then those from a line between two points to a third one.
    let [begin, end] = points_of(graph, points, objects, &ways, between);
    let [start, stop, point] = points_of(graph, points, objects, &ways, to_line);
    let distances = [(end - begin).length(), distance_to_line(graph, start, stop, point)];
    let meters = graph.joined(&distances, 2);
    let tolerances = (meters / graph.scalar(model.tolerance)).cast(DataType::Double);
    let one = graph.scalar(1.0_f64);
    let nearness = (tolerances * tolerances + one).op("Reciprocal");
    let features = graph.joined(&[meters.cast(DataType::Double), nearness], 3);

    // The weights as the model has them are those of pairs and lines as they come.
    let (of_pairs, of_lines): (Vec<_>, Vec<_>) = iter::zip(&ways[0], model.weights.as_chunks().0)
        .partition(|(way, _)| matches!(way, Way::Between(..)));
    let weights: Vec<[f64; 2]> = of_pairs.into_iter().chain(of_lines).map(|(_, it)| *it).collect();
    let weights = graph.constant(&[weights.len(), 2], weights.into_iter().flatten());
    let over_features = graph.whole([2, 3]);
    let no_dims = [("keepdims", Attribute::Int(0))];
    let scores = graph.op("ReduceSum", &[features * weights, over_features], &no_dims);
    graph.op("ArgMax", &[scores], &[("axis", Attribute::Int(1)), no_dims[0]])
}

fn between(way: &Way) -> Option<[Point; 2]> {
    match way {
        Way::Between(begin, end) => Some([*begin, *end]),
        Way::ToLine { .. } => None,
    }
}

fn to_line(way: &Way) -> Option<[Point; 3]> {
    match way {
        Way::Between(..) => None,
        Way::ToLine { start, end, point } => Some([*start, *end, *point]),
    }
}

/// The points of the ways of one kind in each of the K roles that they have there, `[B, orders, distances, 3]`; `points`
/// are the gripper, the objects and their targets, `[B, 1 + 2 N, 3]`.
fn points_of<'g, const K: usize>(
    graph: &'g Graph,
    points: Value<'g>,
    objects: usize,
    ways: &[Vec<Way>],
    kind: impl Fn(&Way) -> Option<[Point; K]>,
) -> [Value<'g>; K] {
    let place = |point: Point| match point {
        Point::Gripper => 0,
        Point::Start(object) => 1 + object,
        Point::Target(object) => 1 + objects + object,
    };
    let orders = ways.iter().map(|order| order.iter().filter_map(&kind).collect::<Vec<_>>());
    let orders: Vec<_> = orders.collect();
    let dims = [orders.len(), orders[0].len()];
    std::array::from_fn(|role| {
        let table = orders.iter().flatten().map(|points| whole(place(points[role])));
        points.gathered(graph.constant(&dims, table), 1)
    })
}

/// From points to the nearest points of straight lines.
fn distance_to_line<'g>(
    graph: &'g Graph,
    start: Value<'g>,
    end: Value<'g>,
    point: Value<'g>,
) -> Value<'g> {
    let (line, reach) = (end - start, point - start);
    let (squared, zero) = (line.dot(line), graph.scalar(0.0_f32));
    let share = line.dot(reach) / squared;
    let share = share.if_else(squared.with("Greater", zero), zero);
    let share = graph.op("Clip", &[share, zero, graph.scalar(1.0_f32)], &[]);
    (reach - line * share).length()
}
