//! Forward and backward passes of one network over some rows.

use super::buffer::{Buffer, padded};
use super::gemm::Gemm;
use super::kernels::{self, Norm};
use super::network::{Dense, Network, Parameters};
use super::pair::{self, Pair};
use super::pair_gemm::PairGemm;
use super::product::{Left, PANEL, PairProduct, Product};
use crate::learner::network::Layer;
use crate::learner::simd::Simd;

/// What the passes run on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Machine {
    pub(super) simd: Simd,
    pub(super) gemm: Gemm,
    pub(super) pair_gemm: PairGemm,
}

impl Machine {
    /// Whether there is neither NaN nor an infinity in `values`.
    pub(super) fn all_finite(self, values: &[f32]) -> bool {
        self.simd.run(
            #[inline(always)]
            || kernels::sum(values, |x| x * 0.0) == 0.0,
        )
    }
}

/// A product of some rows and a layer's weight.
struct Affine<'a> {
    input: Rows<'a>,
    /// `[inputs, stride]`.
    weight: &'a [f32],
    /// `[rows, stride]`.
    out: &'a mut [f32],
    rows: usize,
    inputs: usize,
    stride: usize,
}

impl Machine {
    fn affine(self, affine: Affine<'_>) {
        let Affine { input, weight, out, rows, inputs, stride } = affine;
        if stride == 1 {
            self.simd.run(
                #[inline(always)]
                || kernels::multiply_vector(input.data, input.stride, weight, out),
            );
        } else {
            self.gemm.multiply(Product {
                left: Left::rows(input.data, input.stride),
                right: weight,
                right_stride: stride,
                out,
                out_stride: stride,
                rows,
                depth: inputs,
                columns: stride,
                accumulate: false,
            });
        }
    }
}

/// Rows of a matrix, one every `stride` numbers.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) data: &'a [f32],
    pub(super) stride: usize,
}

/// Where the gradient of every parameter goes, in the layout of the network's shape.
pub(super) struct Gradient<'a> {
    pub(super) values: &'a mut [f32],
    /// Whether to add to what is there.
    pub(super) accumulate: bool,
}

/// What a forward pass leaves for the backward pass.
#[derive(Debug)]
pub(super) struct Trace {
    layers: Vec<LayerTrace>,
    /// The input of a layer in pairs, `[rows, pairs of inputs]`.
    pairs: Buffer<Pair>,
}

#[derive(Debug)]
struct LayerTrace {
    /// After the activation, `[rows, stride]`.
    output: Buffer,
    /// Before scale and shift, `[rows, stride]`; empty without layer normalization.
    normal: Buffer,
    /// `[rows]`; empty without layer normalization.
    inverse_deviation: Buffer,
}

impl Trace {
    pub(super) fn new(layers: &[Dense], rows: usize) -> Self {
        let paired = layers.iter().filter(|dense| dense.paired.is_some());
        let pairs = paired.map(|dense| pair::pairs(dense.layer.inputs)).max().unwrap_or(0);
        let layers = layers
            .iter()
            .map(|dense| {
                let normalized = if dense.layer.norm.is_some() { rows } else { 0 };
                LayerTrace {
                    output: Buffer::zeros(rows * dense.stride),
                    normal: Buffer::zeros(normalized * dense.stride),
                    inverse_deviation: Buffer::zeros(normalized),
                }
            })
            .collect();
        Self { layers, pairs: Buffer::zeros(rows * pairs) }
    }

    /// Outputs of the network, `[rows, stride of the last layer]`.
    pub(super) fn output(&self) -> &[f32] {
        &self.layers[self.layers.len() - 1].output
    }

    pub(super) fn output_mut(&mut self) -> &mut [f32] {
        let last = self.layers.len() - 1;
        &mut self.layers[last].output
    }
}

/// Gradients of a layer's output and of the one before it, `[rows, stride]` each.
#[derive(Debug)]
pub(super) struct Deltas {
    current: Buffer,
    previous: Buffer,
    /// The left and the right matrix of a product in pairs.
    left: Buffer<Pair>,
    right: Buffer<Pair>,
}

impl Deltas {
    pub(super) fn new<'a>(layers: impl Iterator<Item = &'a Dense> + Clone, rows: usize) -> Self {
        let widest = layers.clone().map(|dense| dense.stride.max(dense.transposed_stride()));
        let length = rows * widest.max().unwrap_or(0);
        let paired = layers.filter(|dense| dense.paired.is_some());
        let left = paired.clone().map(|dense| {
            let Layer { inputs, outputs, .. } = dense.layer;
            (pair::pairs(rows) * padded(inputs)).max(rows * pair::pairs(outputs))
        });
        let right = paired.map(|dense| pair::pairs(rows) * dense.stride);
        Self {
            current: Buffer::zeros(length),
            previous: Buffer::zeros(length),
            left: Buffer::zeros(left.max().unwrap_or(0)),
            right: Buffer::zeros(right.max().unwrap_or(0)),
        }
    }

    /// Where the gradient of the network's output goes, `[rows, stride of the last layer]`.
    pub(super) fn output_mut(&mut self) -> &mut [f32] {
        &mut self.current
    }
}

impl Network {
    /// Leaves the network's output for `input` in `trace`.
    pub(super) fn forward(
        &self,
        machine: Machine,
        parameters: &Parameters,
        input: Rows<'_>,
        rows: usize,
        trace: &mut Trace,
    ) {
        let last = self.layers.len() - 1;
        for (index, dense) in self.layers.iter().enumerate() {
            let Trace { layers, pairs } = &mut *trace;
            let (before, after) = layers.split_at_mut(index);
            let LayerTrace { output, normal, inverse_deviation } = &mut after[0];
            let (layer, stride) = (&dense.layer, dense.stride);
            let input = match before.last() {
                Some(trace) => Rows { data: &trace.output, stride: self.layers[index - 1].stride },
                None => input,
            };
            let output = &mut output[..rows * stride];
            let normal = if layer.norm.is_some() { &mut normal[..rows * stride] } else { normal };
            let out = if layer.norm.is_some() { &mut *normal } else { &mut *output };
            if let Some(paired) = &dense.paired {
                let depth = pair::pairs(layer.inputs);
                let pairs = &mut pairs[..rows * depth];
                machine.simd.run(
                    #[inline(always)]
                    || pair::pair_columns(input.data, input.stride, layer.inputs, pairs),
                );
                machine.pair_gemm.multiply(PairProduct {
                    left: Left::rows(pairs, depth),
                    right: parameters.pairs(paired),
                    out,
                    out_stride: stride,
                    rows,
                    depth,
                    columns: stride,
                    accumulate: false,
                });
            } else {
                let (weight, inputs) = (parameters.weight(dense), layer.inputs);
                machine.affine(Affine { input, weight, out, rows, inputs, stride });
            }
            let bias = &parameters.flat[layer.bias.clone()];
            if let Some((scale, shift)) = &layer.norm {
                let norm = Norm {
                    scale: &parameters.flat[scale.clone()],
                    shift: &parameters.flat[shift.clone()],
                };
                machine.simd.run(
                    #[inline(always)]
                    || {
                        kernels::normalize_and_rectify(
                            normal,
                            output,
                            stride,
                            inverse_deviation,
                            bias,
                            &norm,
                        );
                    },
                );
            } else if index < last {
                machine.simd.run(
                    #[inline(always)]
                    || kernels::add_bias_and_rectify(output, stride, bias),
                );
            } else {
                machine.simd.run(
                    #[inline(always)]
                    || kernels::add_bias(output, stride, bias),
                );
            }
        }
    }

    /// Finds the gradient of every parameter, from the gradient of the output in `deltas`.
    pub(super) fn backward(
        &self,
        machine: Machine,
        input: Rows<'_>,
        rows: usize,
        trace: &Trace,
        deltas: &mut Deltas,
        gradient: Gradient<'_>,
    ) {
        let Gradient { values, accumulate } = gradient;
        let last = self.layers.len() - 1;
        for (index, dense) in self.layers.iter().enumerate().rev() {
            let (layer, stride) = (&dense.layer, dense.stride);
            let (weight, vectors) = values[layer.weight.start..].split_at_mut(layer.weight.len());
            if !accumulate {
                let count = if layer.norm.is_some() { 3 } else { 1 };
                vectors[..count * layer.outputs].fill(0.0);
            }
            let (bias, vectors) = vectors.split_at_mut(layer.outputs);
            let delta = &mut deltas.current[..rows * stride];
            if let Some((scale, _)) = &layer.norm {
                let (scale_gradient, vectors) = vectors.split_at_mut(layer.outputs);
                let shift_gradient = &mut vectors[..layer.outputs];
                let LayerTrace { output, normal, inverse_deviation } = &trace.layers[index];
                let scale = &self.online.flat[scale.clone()];
                machine.simd.run(
                    #[inline(always)]
                    || {
                        kernels::mask_and_sum(delta, output, stride, shift_gradient);
                        kernels::sum_products(delta, normal, stride, scale_gradient);
                        kernels::normalize_backward(
                            delta,
                            normal,
                            stride,
                            inverse_deviation,
                            scale,
                        );
                        kernels::sum_rows(delta, stride, bias);
                    },
                );
            } else if index < last {
                let output = &trace.layers[index].output;
                machine.simd.run(
                    #[inline(always)]
                    || kernels::mask_and_sum(delta, output, stride, bias),
                );
            } else {
                machine.simd.run(
                    #[inline(always)]
                    || kernels::sum_rows(delta, stride, bias),
                );
            }
            let input = match index.checked_sub(1) {
                Some(before) => {
                    Rows { data: &trace.layers[before].output, stride: self.layers[before].stride }
                }
                None => input,
            };
            if stride == 1 {
                machine.simd.run(
                    #[inline(always)]
                    || {
                        if !accumulate {
                            weight.fill(0.0);
                        }
                        kernels::add_weighted_rows(input.data, input.stride, delta, weight);
                    },
                );
            } else if dense.paired.is_some() {
                let depth = pair::pairs(rows);
                let inputs = padded(layer.inputs);
                let left = &mut deltas.left[..depth * inputs];
                let right = &mut deltas.right[..depth * stride];
                machine.simd.run(
                    #[inline(always)]
                    || {
                        let (data, width) = (input.data, layer.inputs);
                        pair::pair_rows(data, input.stride, rows, width, inputs, left);
                        pair::pair_rows(delta, stride, rows, stride, PANEL, right);
                    },
                );
                machine.pair_gemm.multiply(PairProduct {
                    left: Left::transposed(left, inputs),
                    right,
                    out: weight,
                    out_stride: layer.outputs,
                    rows: layer.inputs,
                    depth,
                    columns: layer.outputs,
                    accumulate,
                });
            } else {
                machine.gemm.multiply(Product {
                    left: Left::transposed(input.data, input.stride),
                    right: delta,
                    right_stride: stride,
                    out: weight,
                    out_stride: layer.outputs,
                    rows: layer.inputs,
                    depth: rows,
                    columns: layer.outputs,
                    accumulate,
                });
            }
            if index > 0 {
                self.step_back(machine, dense, rows, deltas);
            }
        }
    }

    /// Writes the gradient of the differentiated inputs, `[rows, padded]`, and no other.
    pub(super) fn backward_to_input(
        &self,
        machine: Machine,
        rows: usize,
        trace: &Trace,
        deltas: &mut Deltas,
        input_gradient: &mut [f32],
    ) {
        let last = self.layers.len() - 1;
        for (index, dense) in self.layers.iter().enumerate().rev() {
            let (layer, stride) = (&dense.layer, dense.stride);
            let delta = &mut deltas.current[..rows * stride];
            if index < last {
                let LayerTrace { output, normal, inverse_deviation } = &trace.layers[index];
                machine.simd.run(
                    #[inline(always)]
                    || kernels::mask(delta, output),
                );
                if let Some((scale, _)) = &layer.norm {
                    let scale = &self.online.flat[scale.clone()];
                    machine.simd.run(
                        #[inline(always)]
                        || {
                            kernels::normalize_backward(
                                delta,
                                normal,
                                stride,
                                inverse_deviation,
                                scale,
                            );
                        },
                    );
                }
            }
            self.step_back(machine, dense, rows, deltas);
        }
        let wanted = rows * self.layers[0].transposed_stride();
        input_gradient[..wanted].copy_from_slice(&deltas.current[..wanted]);
    }

    /// From the gradient of a layer's affine map to that of its input.
    fn step_back(&self, machine: Machine, dense: &Dense, rows: usize, deltas: &mut Deltas) {
        let (stride, back) = (dense.stride, dense.transposed_stride());
        let Deltas { current, previous, left, .. } = deltas;
        if stride == 1 {
            let factors = &current[..rows];
            let out = &mut previous[..rows * back];
            machine.simd.run(
                #[inline(always)]
                || kernels::outer(factors, self.transposed(dense), out),
            );
        } else if let Some(paired) = &dense.paired {
            let depth = pair::pairs(dense.layer.outputs);
            let left = &mut left[..rows * depth];
            machine.simd.run(
                #[inline(always)]
                || pair::pair_columns(current, stride, dense.layer.outputs, left),
            );
            machine.pair_gemm.multiply(PairProduct {
                left: Left::rows(left, depth),
                right: self.transposed_pairs(paired),
                out: previous,
                out_stride: back,
                rows,
                depth,
                columns: back,
                accumulate: false,
            });
        } else {
            machine.gemm.multiply(Product {
                left: Left::rows(current, stride),
                right: self.transposed(dense),
                right_stride: back,
                out: previous,
                out_stride: back,
                rows,
                depth: dense.layer.outputs,
                columns: back,
                accumulate: false,
            });
        }
        std::mem::swap(&mut deltas.current, &mut deltas.previous);
    }
}
