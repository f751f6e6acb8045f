//! What the network sees, as operators: [`crate::input`] and [`crate::goal`] step by step, in single
//! precision like them, so that both decide the same.
//!
//! Shapes in comments are those of a batch of B rows, with N objects and S = N + 1 slots of a goal,
//! of which the first is the gripper's.

use super::graph::{Attribute, Element, Graph, Value, whole};
use super::inputs::{Inputs, Scene};
use super::order;
use super::proto::DataType;
use crate::config::GoalFrame;
use crate::env::SignedIndex;
use crate::input::{CLIP, FAR, FineScale, InputEncoder, NEAR, Turns};
use std::iter;

/// Rows of observations under one of several exchanges of objects, `which` of them `[B]`.
fn exchanged<'g>(
    graph: &'g Graph,
    observation: Value<'g>,
    exchanges: &[&[SignedIndex]],
    which: Value<'g>,
) -> Value<'g> {
    fn chosen<'g, T: Element>(
        graph: &'g Graph,
        exchanges: &[&[SignedIndex]],
        which: Value<'g>,
        of: impl Fn(&SignedIndex) -> T,
    ) -> Value<'g> {
        let dims = [exchanges.len(), exchanges[0].len()];
        let table = exchanges.iter().flat_map(|images| images.iter().map(&of));
        graph.constant(&dims, table).gathered(which, 0)
    }
    let from = chosen(graph, exchanges, which, |image| whole(image.from));
    let along_row = [("axis", Attribute::Int(1))];
    let moved = graph.op("GatherElements", &[observation, from], &along_row);
    let sign = chosen(graph, exchanges, which, |image| image.sign);
    let offset = chosen(graph, exchanges, which, |image| image.offset);
    sign * moved + offset
}

/// The input of the network, `[B, inputs]`.
pub(super) fn encoded<'g>(
    graph: &'g Graph,
    inputs: Inputs<'_>,
    encoder: &InputEncoder,
) -> Value<'g> {
    // Whatever else an encoder comes to hold has to find its place here.
    // Tails are refused before.
    let InputEncoder { frame, observation: statistics, slots, tail: _, turns, fine_scale, order } =
        encoder;
    let (count, last) = (inputs.objects(), inputs.last());
    let mut observation = graph.input("observation");
    let Scene { gripper, mut objects } = inputs.scene(graph, "observation", "achieved_goal");
    let mut targets = inputs.targets(graph);
    if let Some(model) = order {
        let begun = inputs.scene(graph, "first_observation", "first_achieved_goal");
        let chosen = order::choice(graph, model, count, begun, targets);
        let given: Vec<usize> = (0..count).collect();
        let orders = iter::once(&given).chain(model.others.iter().map(|other| &other.order));
        let orders: Vec<i64> = orders.flatten().copied().map(whole).collect();
        let relay = graph.constant(&[model.others.len() + 1, count], orders).gathered(chosen, 0);
        let same = SignedIndex::none(statistics.width());
        let others = model.others.iter().map(|other| &*other.observation);
        let exchanges: Vec<_> = iter::once(&*same).chain(others).collect();
        observation = exchanged(graph, observation, &exchanges, chosen);
        (objects, targets) = (objects.in_order(relay), targets.in_order(relay));
    }

    // The goal of the whole task: what it is not about stays where it is.
    let mut wanted = targets.part(0, last + 1, 1);
    if last + 1 < count {
        wanted = graph.joined(&[wanted, objects.part(last + 1, count, 1)], 1);
    }
    let (wanted_gripper, blank_slot) =
        if inputs.is_reach() { (objects.part(last, last + 1, 1), last + 1) } else { (gripper, 0) };
    let mut places = graph.joined(&[gripper, objects], 1);
    let mut wanted = graph.joined(&[wanted_gripper, wanted], 1);
    let mut by_turn = None;
    if let Some(turns) = turns.as_ref().filter(|_| last > 0) {
        let first = first_in_turn(graph, turns, last, objects, targets);
        let exchanges: Vec<_> = turns.observations.iter().map(Vec::as_slice).collect();
        observation = exchanged(graph, observation, &exchanges, first);
        let in_turn = (0..count)
            .flat_map(|turn| iter::once(0).chain((0..count).map(move |it| 1 + (turn + it) % count)))
            .map(whole);
        let order = graph.constant(&[count, count + 1], in_turn).gathered(first, 0);
        (places, wanted) = (places.in_order(order), wanted.in_order(order));
        by_turn = Some(order);
    }

    let slots_count = count + 1;
    let is_relative = *frame == GoalFrame::Relative;
    let difference = wanted - places;
    let position = if is_relative { difference } else { wanted };
    let position = position.normalized(&[slots_count, 3], slots);
    let blank = by_slot(graph, by_turn, (0..slots_count).map(|slot| slot == blank_slot));
    let unused = graph.scalar(if is_relative { 0.0 } else { -CLIP });
    let mut parts = vec![
        observation.normalized(&[statistics.width()], std::slice::from_ref(statistics)),
        unused.if_else(blank, position).reshaped([3 * slots_count]),
    ];
    if is_relative {
        let batch = [("start", Attribute::Int(0)), ("end", Attribute::Int(1))];
        let rows = graph.op("Shape", &[graph.input("observation")], &batch);
        let shape = graph.joined(&[rows, graph.whole([whole(slots_count), 1])], 0);
        let flags = blank.cast(DataType::Float).with("Expand", shape);
        parts.push(flags.reshaped([slots_count]));
    }
    if let Some(FineScale { tolerances }) = fine_scale {
        let unit = by_slot(graph, by_turn, tolerances.iter().copied());
        parts.push(goal_on_fine_scale(graph, count, difference, blank, unit));
        parts.extend(places_on_fine_scale(count, places, unit));
    }
    graph.joined(&parts, 1)
}

/// What each slot has, `[B, S, 1]` in an order `[B, S]`, and `[1, S, 1]` without one.
fn by_slot<'g, T: Element>(
    graph: &'g Graph,
    order: Option<Value<'g>>,
    values: impl ExactSizeIterator<Item = T>,
) -> Value<'g> {
    let slots = values.len();
    match order {
        None => graph.constant(&[1, slots, 1], values),
        Some(order) => graph.constant(&[slots, 1], values).gathered(order, 0),
    }
}

/// The object whose turn it is, `[B]`: the first that is not at its target, or the last.
fn first_in_turn<'g>(
    graph: &'g Graph,
    turns: &Turns,
    last: usize,
    objects: Value<'g>,
    targets: Value<'g>,
) -> Value<'g> {
    let away = (targets.part(0, last, 1) - objects.part(0, last, 1)).length().reshaped([last]);
    let tolerances = graph.constant(&[last], turns.tolerances[..last].iter().copied());
    let misplaced = away.with("LessOrEqual", tolerances).op("Not").cast(DataType::Float);
    let padding = [graph.whole([0, 0, 0, 1]), graph.scalar(1.0_f32)];
    let padded = graph.op("Pad", &[misplaced, padding[0], padding[1]], &[]);
    let over_row = [("axis", Attribute::Int(1)), ("keepdims", Attribute::Int(0))];
    graph.op("ArgMax", &[padded], &over_row)
}

/// Differences to the goal in units of the tolerance, and their lengths, clipped to what is near;
/// `[B, 4 S]`.
fn goal_on_fine_scale<'g>(
    graph: &'g Graph,
    objects: usize,
    difference: Value<'g>,
    blank: Value<'g>,
    unit: Value<'g>,
) -> Value<'g> {
    let scaled = difference / unit;
    let length = scaled.length().with("Min", graph.scalar(FAR));
    let beyond = length - graph.scalar(1.0_f32);
    let goal = graph.joined(&[scaled.clipped(NEAR), beyond], 2);
    graph.scalar(0.0_f32).if_else(blank, goal).reshaped([4 * (objects + 1)])
}

/// From the gripper to every object, and from the first object to every later one.
fn places_on_fine_scale<'g>(
    objects: usize,
    places: Value<'g>,
    unit: Value<'g>,
) -> impl Iterator<Item = Value<'g>> {
    (0..objects.min(2)).map(move |origin| {
        let others = |value: Value<'g>| value.part(origin + 1, objects + 1, 1);
        let away = others(places) - places.part(origin, origin + 1, 1);
        (away / others(unit)).clipped(NEAR).reshaped([3 * (objects - origin)])
    })
}
