//! Forward passes for acting: no autodiff, no allocation, the same bits whatever the vector width.

#![expect(
    clippy::inline_always,
    reason = "wide registers are for what is inlined under `dispatch`"
)]

use super::network::{Layer, NORM_EPSILON, Shape};
use super::simd;
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// Rows that go through the layers together, so that their activations stay in the nearest cache.
const BLOCK: usize = 16;

/// A network's layers and room for their activations.
///
/// A row's outputs do not depend on the rows beside it, down to the last bit.
#[derive(Clone, Debug)]
pub struct Inference {
    inputs: usize,
    outputs: usize,
    layers: Vec<Layer>,
    now: Vec<f32>,
    next: Vec<f32>,
}

impl Inference {
    /// Room for a network of this shape.
    pub fn new(shape: &Shape) -> Self {
        let widest = shape.hidden.iter().copied().fold(shape.inputs.max(shape.outputs), usize::max);
        Self {
            inputs: shape.inputs,
            outputs: shape.outputs,
            layers: shape.layers(),
            now: vec![0.0; BLOCK * widest],
            next: vec![0.0; BLOCK * widest],
        }
    }

    /// Writes the actor's actions, `[rows, outputs]`, for inputs, `[rows, inputs]`.
    pub fn act(&mut self, parameters: &[f32], inputs: &[f32], actions: &mut [f32]) {
        self.forward(parameters, inputs, actions);
        for action in actions {
            *action = libm::tanhf(*action);
        }
    }

    /// Writes the network's outputs, `[rows, outputs]`, for inputs, `[rows, inputs]`.
    pub fn forward(&mut self, parameters: &[f32], inputs: &[f32], outputs: &mut [f32]) {
        simd::Simd::chosen_or_fastest().arch().dispatch(Forward {
            inference: self,
            parameters,
            inputs,
            outputs,
        });
    }

    #[inline(always)]
    fn forward_block<S: Simd>(
        &mut self,
        simd: S,
        parameters: &[f32],
        inputs: &[f32],
        outputs: &mut [f32],
    ) {
        let rows = inputs.len() / self.inputs;
        let Self { layers, now, next, .. } = self;
        now[..inputs.len()].copy_from_slice(inputs);
        for (index, layer) in layers.iter().enumerate() {
            let sums = &mut next[..rows * layer.outputs];
            affine(simd, layer, parameters, &now[..rows * layer.inputs], sums);
            if let Some((scale, shift)) = &layer.norm {
                normalize(&parameters[scale.clone()], &parameters[shift.clone()], sums);
            }
            if index + 1 < layers.len() {
                for sum in sums {
                    *sum = if *sum < 0.0 { 0.0 } else { *sum };
                }
            }
            std::mem::swap(now, next);
        }
        outputs.copy_from_slice(&now[..outputs.len()]);
    }
}

/// The arguments of [`Inference::forward`], to be compiled for every kind of processor.
struct Forward<'a> {
    inference: &'a mut Inference,
    parameters: &'a [f32],
    inputs: &'a [f32],
    outputs: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { inference, parameters, inputs, outputs } = self;
        let inputs = inputs.chunks(BLOCK * inference.inputs);
        let outputs = outputs.chunks_mut(BLOCK * inference.outputs);
        for (inputs, outputs) in inputs.zip(outputs) {
            inference.forward_block(simd, parameters, inputs, outputs);
        }
    }
}

/// Writes bias plus weighted inputs, in tiles of sums that stay in registers.
///
/// A tile has eight vectors: enough to hide how long an addition takes, few enough for AVX2.
#[inline(always)]
fn affine<S: Simd>(simd: S, layer: &Layer, parameters: &[f32], inputs: &[f32], sums: &mut [f32]) {
    let quads = inputs.chunks(4 * layer.inputs).zip(sums.chunks_mut(4 * layer.outputs));
    for (inputs, sums) in quads {
        if sums.len() == 4 * layer.outputs {
            stripe::<S, 4, 2>(simd, layer, parameters, inputs, sums);
        } else {
            let rows = inputs.chunks(layer.inputs).zip(sums.chunks_mut(layer.outputs));
            for (inputs, sums) in rows {
                stripe::<S, 1, 8>(simd, layer, parameters, inputs, sums);
            }
        }
    }
}

/// The tiles of `ROWS` rows, most of them `VECTORS` vectors wide.
#[inline(always)]
fn stripe<S: Simd, const ROWS: usize, const VECTORS: usize>(
    simd: S,
    layer: &Layer,
    parameters: &[f32],
    inputs: &[f32],
    sums: &mut [f32],
) {
    let wide = VECTORS * S::F32_LANES;
    let mut from = 0;
    while from + wide <= layer.outputs {
        let columns = from..from + wide;
        tile::<S, ROWS, VECTORS>(simd, layer, parameters, inputs, sums, columns);
        from += wide;
    }
    while from < layer.outputs {
        let columns = from..layer.outputs.min(from + S::F32_LANES);
        from = columns.end;
        tile::<S, ROWS, 1>(simd, layer, parameters, inputs, sums, columns);
    }
}

/// One tile; every sum takes its weighted inputs in their order.
#[inline(always)]
fn tile<S: Simd, const ROWS: usize, const VECTORS: usize>(
    simd: S,
    layer: &Layer,
    parameters: &[f32],
    inputs: &[f32],
    sums: &mut [f32],
    columns: Range<usize>,
) {
    let bias = load::<S, VECTORS>(simd, &parameters[layer.bias.clone()][columns.clone()]);
    let mut tile = [bias; ROWS];
    let weights = parameters[layer.weight.clone()].chunks_exact(layer.outputs);
    for (index, weights) in weights.enumerate() {
        let weights = load::<S, VECTORS>(simd, &weights[columns.clone()]);
        for (row, sums) in tile.iter_mut().enumerate() {
            let input = simd.splat_f32s(inputs[row * layer.inputs + index]);
            for (sum, weight) in sums.iter_mut().zip(weights) {
                *sum = simd.add_f32s(*sum, simd.mul_f32s(input, weight));
            }
        }
    }
    for (row, tile) in sums.chunks_exact_mut(layer.outputs).zip(tile) {
        for (sums, vector) in row[columns.clone()].chunks_mut(S::F32_LANES).zip(tile) {
            simd.partial_store_f32s(sums, vector);
        }
    }
}

/// As many numbers as fit, zeros where there are fewer.
#[inline(always)]
fn load<S: Simd, const VECTORS: usize>(simd: S, values: &[f32]) -> [S::f32s; VECTORS] {
    match S::as_simd_f32s(values).0.first_chunk() {
        Some(vectors) => *vectors,
        None => [simd.partial_load_f32s(values); VECTORS],
    }
}

/// Layer normalization of every row.
#[inline(always)]
fn normalize(scale: &[f32], shift: &[f32], rows: &mut [f32]) {
    let width = scale.len() as f32;
    for row in rows.chunks_exact_mut(scale.len()) {
        let mean = row.iter().sum::<f32>() / width;
        let variance = row.iter().map(|x| (x - mean) * (x - mean)).sum::<f32>() / width;
        let factor = 1.0 / (variance + NORM_EPSILON).sqrt();
        for ((x, scale), shift) in row.iter_mut().zip(scale).zip(shift) {
            *x = (*x - mean) * factor * scale + shift;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Init;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_row_has_the_same_bits_in_any_company_and_on_any_processor() {
        for (hidden, layer_norm) in [(vec![256, 64], false), (vec![37, 5], true)] {
            let shape = Shape { inputs: 31, hidden, outputs: 4, layer_norm };
            let mut rng = ChaCha8Rng::seed_from_u64(9);
            let parameters = shape.draw(Init::FanIn, &mut rng);
            let inputs: Vec<f32> = (0..39 * 31).map(|_| rng.random_range(-5.0..5.0)).collect();
            let bits = |outputs: &[f32]| outputs.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let mut inference = Inference::new(&shape);
            let mut scalar = vec![0.0; 39 * 4];
            Forward {
                inference: &mut inference,
                parameters: &parameters,
                inputs: &inputs,
                outputs: &mut scalar,
            }
            .with_simd(pulp::Scalar::new());
            for rows in [1, 2, 7, 16, 39] {
                let mut outputs = vec![0.0; 39 * 4];
                let groups = inputs.chunks(rows * 31).zip(outputs.chunks_mut(rows * 4));
                groups.for_each(|(from, to)| inference.forward(&parameters, from, to));
                assert_eq!(bits(&outputs), bits(&scalar), "{rows} rows at a time");
            }
        }
    }

    #[test]
    fn actions_are_squashed() {
        let shape = Shape { inputs: 1, hidden: vec![1], outputs: 1, layer_norm: false };
        let mut action = [0.0];
        Inference::new(&shape).act(&[2.0, 1.0, 0.5, -1.0], &[3.0], &mut action);
        assert_eq!(action.map(f32::to_bits), [libm::tanhf(2.5).to_bits()]);
    }
}
