//! Networks as plain numbers: one flat vector of parameters and a shape that says what is where.

use crate::config::Init;
use rand::{Rng, RngExt as _};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Guard against division by zero in layer normalization.
pub const NORM_EPSILON: f32 = 1e-5;

/// Layers of a fully connected network with rectified hidden layers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Numbers in an input.
    pub inputs: usize,
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// Numbers in an output.
    pub outputs: usize,
    /// Layer normalization between each hidden layer's affine map and its activation.
    pub layer_norm: bool,
}

/// Where the parameters of one layer are in the flat vector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Numbers in.
    pub inputs: usize,
    /// Numbers out.
    pub outputs: usize,
    /// `[inputs, outputs]`, row-major.
    pub weight: Range<usize>,
    /// `[outputs]`.
    pub bias: Range<usize>,
    /// Scale and shift of the layer normalization, `[outputs]` each.
    pub norm: Option<(Range<usize>, Range<usize>)>,
}

/// One named tensor of a network, as files and tests see it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tensor {
    /// Such as `layers.0.weight`.
    pub name: String,
    /// Its dimensions.
    pub dims: Vec<usize>,
    /// Where it is in the flat vector.
    pub range: Range<usize>,
}

impl Shape {
    /// The layers, first to last, and where their parameters are.
    pub fn layers(&self) -> Vec<Layer> {
        let mut next = 0;
        let mut take = |count: usize| {
            let range = next..next + count;
            next += count;
            range
        };
        let widths: Vec<usize> = std::iter::once(self.inputs)
            .chain(self.hidden.iter().copied())
            .chain([self.outputs])
            .collect();
        let last = widths.len() - 2;
        widths
            .windows(2)
            .enumerate()
            .map(|(index, pair)| Layer {
                inputs: pair[0],
                outputs: pair[1],
                weight: take(pair[0] * pair[1]),
                bias: take(pair[1]),
                norm: (self.layer_norm && index != last).then(|| (take(pair[1]), take(pair[1]))),
            })
            .collect()
    }

    /// Every tensor, in the order of the flat vector.
    pub fn tensors(&self) -> Vec<Tensor> {
        let mut tensors = Vec::new();
        for (index, layer) in self.layers().into_iter().enumerate() {
            let Layer { inputs, outputs, weight, bias, norm } = layer;
            let mut push = |name: &str, dims: Vec<usize>, range| {
                tensors.push(Tensor { name: format!("layers.{index}.{name}"), dims, range });
            };
            push("weight", vec![inputs, outputs], weight);
            push("bias", vec![outputs], bias);
            if let Some((scale, shift)) = norm {
                push("norm.scale", vec![outputs], scale);
                push("norm.shift", vec![outputs], shift);
            }
        }
        tensors
    }

    /// How many parameters there are.
    pub fn parameters(&self) -> usize {
        self.tensors().last().map_or(0, |tensor| tensor.range.end)
    }

    /// How many parameters there are, computed without making anything; `None` where the count
    /// exceeds every memory, which it can in a damaged file.
    pub fn checked_parameters(&self) -> Option<usize> {
        let widths = self.hidden.iter().chain([&self.outputs]);
        let norm = if self.layer_norm { 2 } else { 0 };
        let mut count = 0_usize;
        let mut inputs = self.inputs;
        for (index, &outputs) in widths.enumerate() {
            let vectors = if index < self.hidden.len() { 1 + norm } else { 1 };
            let layer = inputs.checked_add(vectors)?.checked_mul(outputs)?;
            count = count.checked_add(layer)?;
            inputs = outputs;
        }
        Some(count)
    }

    /// Draws the parameters of an untrained network.
    pub fn draw(&self, init: Init, rng: &mut impl Rng) -> Vec<f32> {
        let mut values = vec![0.0; self.parameters()];
        for Layer { inputs, outputs, weight, bias, norm } in self.layers() {
            let bound = match init {
                Init::Xavier => (6.0 / (inputs + outputs) as f32).sqrt(),
                Init::FanIn => 1.0 / (inputs as f32).sqrt(),
            };
            values[weight].fill_with(|| rng.random_range(-bound..bound));
            if init == Init::FanIn {
                values[bias].fill_with(|| rng.random_range(-bound..bound));
            }
            if let Some((scale, _)) = norm {
                values[scale].fill(1.0);
            }
        }
        values
    }
}
