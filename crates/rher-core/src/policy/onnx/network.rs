//! The network of a policy, from its input to an action.

use super::graph::{Attribute, Graph, Value};
use super::proto::DataType;
use crate::learner::network::{Layer, NORM_EPSILON, Shape};
use std::ops::Range;

/// Rectified layers, and numbers within −1 and 1 at the end.
///
/// In double precision: runtimes sum in orders of their own, and where large terms cancel, that would
/// differ from this crate's sums by more than these differ from the exact ones.
pub(super) fn action<'g>(
    graph: &'g Graph,
    input: Value<'g>,
    shape: &Shape,
    parameters: &[f32],
) -> Value<'g> {
    let doubled = |dims: &[usize], range: Range<usize>| {
        graph.constant(dims, parameters[range].iter().copied()).cast(DataType::Double)
    };
    let layers = shape.layers();
    let last = layers.len() - 1;
    let mut values = input.cast(DataType::Double);
    for (index, Layer { inputs, outputs, weight, bias, norm }) in layers.into_iter().enumerate() {
        let (weight, bias) = (doubled(&[inputs, outputs], weight), doubled(&[outputs], bias));
        values = graph.op("Gemm", &[values, weight, bias], &[]);
        if let Some((scale, shift)) = norm {
            let (scale, shift) = (doubled(&[outputs], scale), doubled(&[outputs], shift));
            let epsilon = [("epsilon", Attribute::Float(NORM_EPSILON))];
            values = graph.op("LayerNormalization", &[values, scale, shift], &epsilon);
        }
        values = values.op(if index == last { "Tanh" } else { "Relu" });
    }
    values.cast(DataType::Float)
}

/// The action, or NaN in rows where one of `inputs` is not finite: they must not be carried out.
pub(super) fn unless_finite<'g>(
    graph: &'g Graph,
    action: Value<'g>,
    inputs: &[Value<'g>],
) -> Value<'g> {
    let numbers = graph.joined(inputs, 1).op("Abs");
    let finite = numbers.with("LessOrEqual", graph.scalar(f32::MAX)).cast(DataType::Int32);
    let over_row = [("axes", Attribute::Ints(&[1])), ("keepdims", Attribute::Int(1))];
    let all_finite = graph.op("ReduceMin", &[finite], &over_row).cast(DataType::Bool);
    action.if_else(all_finite, graph.scalar(f32::NAN))
}
