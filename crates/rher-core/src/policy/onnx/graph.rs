//! A graph of ONNX operators, written like the computation that it stands for.

use super::proto::{
    AttributeProto, AttributeType, DataType, Dimension, GraphProto, NodeProto, TensorProto,
    TensorShapeProto, TensorType, TypeProto, ValueInfoProto,
};
use crate::input::{CLIP, Normalizer};
use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Sub};

/// Nodes and constants, in the order in which they were written.
#[derive(Default)]
pub(super) struct Graph {
    nodes: RefCell<Vec<NodeProto>>,
    constants: RefCell<Vec<TensorProto>>,
    values: Cell<usize>,
}

/// A tensor that is known when the graph is computed.
#[derive(Clone, Copy)]
pub(super) struct Value<'g> {
    graph: &'g Graph,
    name: Name,
}

#[derive(Clone, Copy)]
enum Name {
    /// An input of the graph.
    Input(&'static str),
    /// The one with this number.
    Number(usize),
}

/// What a constant consists of.
pub(super) trait Element {
    const TYPE: DataType;
    fn bytes(&self) -> impl IntoIterator<Item = u8>;
}

macro_rules! element {
    ($number:ty, $data_type:ident) => {
        impl Element for $number {
            const TYPE: DataType = DataType::$data_type;
            fn bytes(&self) -> impl IntoIterator<Item = u8> {
                self.to_le_bytes()
            }
        }
    };
}

element!(f32, Float);
element!(f64, Double);
element!(i64, Int64);

impl Element for bool {
    const TYPE: DataType = DataType::Bool;
    fn bytes(&self) -> impl IntoIterator<Item = u8> {
        [u8::from(*self)]
    }
}

/// A constant of an operator.
#[derive(Clone, Copy)]
pub(super) enum Attribute<'a> {
    Int(i64),
    Ints(&'a [i64]),
    Float(f32),
    Type(DataType),
}

impl Attribute<'_> {
    fn named(self, name: &str) -> AttributeProto {
        let mut proto = AttributeProto { name: Some(name.to_owned()), ..AttributeProto::default() };
        let kind = match self {
            Self::Int(number) => {
                proto.i = Some(number);
                AttributeType::Int
            }
            Self::Type(data_type) => {
                proto.i = Some(i64::from(data_type as i32));
                AttributeType::Int
            }
            Self::Ints(numbers) => {
                numbers.clone_into(&mut proto.ints);
                AttributeType::Ints
            }
            Self::Float(number) => {
                proto.f = Some(number);
                AttributeType::Float
            }
        };
        proto.set_type(kind);
        proto
    }
}

/// A length or an index, as ONNX has them.
pub(super) fn whole(number: usize) -> i64 {
    i64::try_from(number).expect("nothing in memory is that long")
}

impl Graph {
    /// One of the inputs of [`Graph::finish`].
    pub(super) fn input(&self, name: &'static str) -> Value<'_> {
        Value { graph: self, name: Name::Input(name) }
    }

    /// A constant of this shape.
    pub(super) fn constant<T: Element>(
        &self,
        dims: &[usize],
        numbers: impl IntoIterator<Item = T>,
    ) -> Value<'_> {
        let value = self.value();
        let mut tensor = TensorProto {
            dims: dims.iter().copied().map(whole).collect(),
            name: Some(value.to_string()),
            raw_data: Some(numbers.into_iter().flat_map(|it| Vec::from_iter(it.bytes())).collect()),
            ..TensorProto::default()
        };
        tensor.set_data_type(T::TYPE);
        self.constants.borrow_mut().push(tensor);
        value
    }

    /// A constant that is one number.
    pub(super) fn scalar<T: Element>(&self, number: T) -> Value<'_> {
        self.constant(&[], [number])
    }

    /// A constant vector of indices or lengths.
    pub(super) fn whole<const K: usize>(&self, numbers: [i64; K]) -> Value<'_> {
        self.constant(&[K], numbers)
    }

    /// The output of an operator.
    pub(super) fn op<'g>(
        &'g self,
        kind: &str,
        inputs: &[Value<'g>],
        attributes: &[(&str, Attribute)],
    ) -> Value<'g> {
        let value = self.value();
        self.nodes.borrow_mut().push(NodeProto {
            input: inputs.iter().map(ToString::to_string).collect(),
            output: vec![value.to_string()],
            op_type: Some(kind.to_owned()),
            attribute: attributes.iter().map(|(name, it)| it.named(name)).collect(),
        });
        value
    }

    /// Values side by side along an axis.
    pub(super) fn joined<'g>(&'g self, values: &[Value<'g>], axis: i64) -> Value<'g> {
        match values {
            [only] => *only,
            _ => self.op("Concat", values, &[("axis", Attribute::Int(axis))]),
        }
    }

    fn value(&self) -> Value<'_> {
        let number = self.values.get();
        self.values.set(number + 1);
        Value { graph: self, name: Name::Number(number) }
    }

    /// The graph from these inputs to this output, each `[batch, width]` in single precision.
    pub(super) fn finish(
        &self,
        inputs: &[(&'static str, usize)],
        (output, width): (&str, usize),
        value: Value<'_>,
    ) -> GraphProto {
        let mut node = self.nodes.borrow().clone();
        node.push(NodeProto {
            input: vec![value.to_string()],
            output: vec![output.to_owned()],
            op_type: Some("Identity".to_owned()),
            attribute: Vec::new(),
        });
        GraphProto {
            node,
            name: Some("policy".to_owned()),
            initializer: self.constants.borrow().clone(),
            input: inputs.iter().map(|(name, width)| rows(name, *width)).collect(),
            output: vec![rows(output, width)],
        }
    }
}

/// Rows of single-precision numbers, any number of them.
fn rows(name: &str, width: usize) -> ValueInfoProto {
    let batch = Dimension { dim_value: None, dim_param: Some("batch".to_owned()) };
    let width = Dimension { dim_value: Some(whole(width)), dim_param: None };
    let shape = Some(TensorShapeProto { dim: vec![batch, width] });
    let mut tensor = TensorType { shape, ..TensorType::default() };
    tensor.set_elem_type(DataType::Float);
    let r#type = Some(TypeProto { tensor_type: Some(tensor) });
    ValueInfoProto { name: Some(name.to_owned()), r#type }
}

impl std::fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.name {
            Name::Input(name) => f.write_str(name),
            Name::Number(number) => write!(f, "value{number}"),
        }
    }
}

impl Value<'_> {
    /// What an operator makes of it alone.
    pub(super) fn op(self, kind: &str) -> Self {
        self.graph.op(kind, &[self], &[])
    }

    /// What an operator makes of it and another value.
    pub(super) fn with(self, kind: &str, other: Self) -> Self {
        self.graph.op(kind, &[self, other], &[])
    }

    /// Its numbers as another type.
    pub(super) fn cast(self, to: DataType) -> Self {
        self.graph.op("Cast", &[self], &[("to", Attribute::Type(to))])
    }

    /// The same numbers in another shape, with as many rows.
    pub(super) fn reshaped<const K: usize>(self, shape: [usize; K]) -> Self {
        // 0 keeps a dimension.
        let shape = std::iter::once(0).chain(shape.into_iter().map(whole));
        self.with("Reshape", self.graph.constant(&[K + 1], shape))
    }

    /// A part of it along an axis.
    pub(super) fn part(self, begin: usize, end: usize, axis: i64) -> Self {
        let [begin, end] = [begin, end].map(|place| self.graph.whole([whole(place)]));
        self.graph.op("Slice", &[self, begin, end, self.graph.whole([axis])], &[])
    }

    /// The parts of it along an axis that `indices` says.
    pub(super) fn gathered(self, indices: Self, axis: i64) -> Self {
        self.graph.op("Gather", &[self, indices], &[("axis", Attribute::Int(axis))])
    }

    /// Numbers within ± `limit`.
    pub(super) fn clipped(self, limit: f32) -> Self {
        let limits = [-limit, limit].map(|limit| self.graph.scalar(limit));
        self.graph.op("Clip", &[self, limits[0], limits[1]], &[])
    }

    /// This where a condition holds, and otherwise another value.
    pub(super) fn if_else(self, condition: Self, other: Self) -> Self {
        self.graph.op("Where", &[condition, self, other], &[])
    }

    /// The product of vectors along the last axis, which has length 3 before and 1 after.
    pub(super) fn dot(self, other: Self) -> Self {
        let products = self * other;
        let [x, y, z] = [0, 1, 2].map(|axis| products.part(axis, axis + 1, -1));
        x + y + z
    }

    /// The lengths of vectors along the last axis, which has length 3 before and 1 after.
    pub(super) fn length(self) -> Self {
        self.dot(self).op("Sqrt")
    }

    /// Numbers in units of their standard deviations, clipped; the statistics have these dimensions.
    pub(super) fn normalized(self, dims: &[usize], statistics: &[Normalizer]) -> Self {
        let mean = statistics.iter().flat_map(|it| it.mean().iter().copied());
        let scale = statistics.iter().flat_map(|it| it.inverse_deviation().iter().copied());
        let (mean, scale) = (self.graph.constant(dims, mean), self.graph.constant(dims, scale));
        ((self - mean) * scale).clipped(CLIP)
    }

    /// Points `[B, S, 3]` in an order `[B, S]`, which each row has its own of.
    pub(super) fn in_order(self, order: Self) -> Self {
        let indices = order.with("Unsqueeze", self.graph.whole([-1]));
        self.graph.op("GatherND", &[self, indices], &[("batch_dims", Attribute::Int(1))])
    }
}

macro_rules! operator {
    ($name:ident, $method:ident) => {
        impl<'g> $name for Value<'g> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.with(stringify!($name), other)
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);
