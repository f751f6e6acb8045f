//! The parameters of one trained network, with the copies that the matrix products want.

use super::buffer::{Buffer, padded};
use super::kernels;
use super::pair::{self, Pair};
use super::product::PANEL;
use crate::config::Precision;
use crate::learner::network::{Layer, Shape};
use crate::learner::simd::Simd;
use crate::learner::state::Trained;
use std::ops::Range;

/// A layer and where its copies are.
#[derive(Clone, Debug)]
pub(super) struct Dense {
    pub(super) layer: Layer,
    /// Numbers from one row of the output to the next: whole vectors, but for a single output.
    pub(super) stride: usize,
    /// In `narrow`, when a row of the weight is no whole number of vectors: `[inputs, stride]`.
    narrow: Option<Range<usize>>,
    /// In `transposed`: `[outputs, padded(rows)]` for the rows of the weight whose input's gradient
    /// is needed.
    transposed: Range<usize>,
    transposed_rows: Range<usize>,
    /// Where the copies in pairs are, of a layer whose products are of bf16 numbers.
    pub(super) paired: Option<Paired>,
}

/// Where the weight of a layer is in pairs, in panels both times.
#[derive(Clone, Debug)]
pub(super) struct Paired {
    /// In `Parameters::pairs`: `[pairs of inputs, outputs]`.
    weight: Range<usize>,
    /// In `Network::transposed_pairs`: `[pairs of outputs, transposed_rows]`.
    transposed: Range<usize>,
}

impl Dense {
    /// Numbers from one row of the transposed weight to the next.
    pub(super) fn transposed_stride(&self) -> usize {
        padded(self.transposed_rows.len())
    }
}

/// Parameters in the layout of their [`Shape`], and copies of some of them.
#[derive(Debug)]
pub(super) struct Parameters {
    pub(super) flat: Buffer,
    narrow: Buffer,
    /// Weights in pairs.
    pairs: Buffer<Pair>,
}

impl Parameters {
    fn new(flat: &[f32], layers: &[Dense], simd: Simd) -> Self {
        let narrow = layers.iter().filter_map(|dense| dense.narrow.as_ref()).map(Range::len).sum();
        let paired = layers.iter().filter_map(|dense| dense.paired.as_ref());
        let mut parameters = Self {
            flat: Buffer::from(flat),
            narrow: Buffer::zeros(narrow),
            pairs: Buffer::zeros(paired.map(|paired| paired.weight.len()).sum()),
        };
        parameters.copy(layers, simd);
        parameters
    }

    /// The weight of a layer whose copies in pairs are at `paired`: `[pairs of inputs, outputs]`.
    pub(super) fn pairs(&self, paired: &Paired) -> &[Pair] {
        &self.pairs[paired.weight.clone()]
    }

    /// The weight of a layer, `[inputs, outputs]` with [`Dense::stride`].
    pub(super) fn weight(&self, dense: &Dense) -> &[f32] {
        match &dense.narrow {
            Some(range) => &self.narrow[range.clone()],
            None => &self.flat[dense.layer.weight.clone()],
        }
    }

    /// After any change of `flat`.
    pub(super) fn copy(&mut self, layers: &[Dense], simd: Simd) {
        for dense in layers {
            let layer = &dense.layer;
            if let Some(paired) = &dense.paired {
                let from = &self.flat[layer.weight.clone()];
                let to = &mut self.pairs[paired.weight.clone()];
                let (rows, columns) = (layer.inputs, layer.outputs);
                simd.run(
                    #[inline(always)]
                    || pair::pair_rows(from, columns, rows, columns, PANEL, to),
                );
            }
            let Some(range) = &dense.narrow else { continue };
            let from = self.flat[dense.layer.weight.clone()].chunks_exact(dense.layer.outputs);
            let to = self.narrow[range.clone()].chunks_exact_mut(dense.stride);
            for (to, from) in to.zip(from) {
                to[..from.len()].copy_from_slice(from);
            }
        }
    }
}

/// A network that is trained, its target and its optimizer.
#[derive(Debug)]
pub(super) struct Network {
    pub(super) shape: Shape,
    pub(super) layers: Vec<Dense>,
    pub(super) online: Parameters,
    pub(super) target: Parameters,
    pub(super) first_moment: Buffer,
    pub(super) second_moment: Buffer,
    pub(super) steps: u64,
    /// Of the last gradient's L2 norm.
    pub(super) squared_norm: f64,
    /// Transposed weights of `online`.
    transposed: Buffer,
    /// The same in pairs.
    transposed_pairs: Buffer<Pair>,
}

impl Network {
    /// `differentiated` are the inputs whose gradient is needed.
    pub(super) fn new(
        trained: Trained,
        differentiated: &Range<usize>,
        precision: Precision,
        simd: Simd,
    ) -> Self {
        let Trained { shape, online, target, first_moment, second_moment, steps } = trained;
        let (mut narrow_end, mut transposed_end) = (0, 0);
        let (mut pairs_end, mut transposed_pairs_end) = (0, 0);
        let layers: Vec<Dense> = shape
            .layers()
            .into_iter()
            .enumerate()
            .map(|(index, layer)| {
                let single = index == shape.hidden.len() && layer.outputs == 1;
                let stride = if single { 1 } else { padded(layer.outputs) };
                let narrow = (layer.outputs != stride).then(|| {
                    let start = narrow_end;
                    narrow_end += layer.inputs * stride;
                    start..narrow_end
                });
                let rows = if index == 0 { differentiated.clone() } else { 0..layer.inputs };
                let start = transposed_end;
                transposed_end += layer.outputs * padded(rows.len());
                let hidden = index < shape.hidden.len();
                let paired = (precision == Precision::Bf16 && hidden).then(|| {
                    let (weight, transposed) = (pairs_end, transposed_pairs_end);
                    pairs_end += pair::pairs(layer.inputs) * stride;
                    transposed_pairs_end += pair::pairs(layer.outputs) * padded(rows.len());
                    Paired {
                        weight: weight..pairs_end,
                        transposed: transposed..transposed_pairs_end,
                    }
                });
                Dense {
                    layer,
                    stride,
                    narrow,
                    transposed: start..transposed_end,
                    transposed_rows: rows,
                    paired,
                }
            })
            .collect();
        let mut network = Self {
            online: Parameters::new(&online, &layers, simd),
            target: Parameters::new(&target, &layers, simd),
            first_moment: Buffer::from(&*first_moment),
            second_moment: Buffer::from(&*second_moment),
            transposed: Buffer::zeros(transposed_end),
            transposed_pairs: Buffer::zeros(transposed_pairs_end),
            shape,
            layers,
            steps,
            squared_norm: 0.0,
        };
        network.copy_online(simd);
        network
    }

    /// After any change of the online parameters.
    pub(super) fn copy_online(&mut self, simd: Simd) {
        let Self { layers, online, transposed, transposed_pairs, .. } = self;
        online.copy(layers, simd);
        for Dense { layer, transposed: range, transposed_rows: rows, paired, .. } in &*layers {
            let from = &online.flat[layer.weight.clone()]
                [rows.start * layer.outputs..rows.end * layer.outputs];
            let to = &mut transposed[range.clone()];
            simd.run(
                #[inline(always)]
                || kernels::transpose(from, layer.outputs, to, padded(rows.len())),
            );
            if let Some(paired) = paired {
                let (from, columns) = (&*to, rows.len());
                let to = &mut transposed_pairs[paired.transposed.clone()];
                simd.run(
                    #[inline(always)]
                    || {
                        let stride = padded(columns);
                        pair::pair_rows(from, stride, layer.outputs, columns, PANEL, to);
                    },
                );
            }
        }
    }

    /// Numbers from one row of the network's output to the next.
    pub(super) fn output_stride(&self) -> usize {
        self.layers[self.layers.len() - 1].stride
    }

    /// The transposed weight of a layer, `[outputs, wanted inputs]`.
    pub(super) fn transposed(&self, dense: &Dense) -> &[f32] {
        &self.transposed[dense.transposed.clone()]
    }

    /// The transposed weight of a layer whose copies in pairs are at `paired`: `[pairs of outputs,
    /// wanted inputs]`.
    pub(super) fn transposed_pairs(&self, paired: &Paired) -> &[Pair] {
        &self.transposed_pairs[paired.transposed.clone()]
    }

    pub(super) fn trained(&self) -> Trained {
        Trained {
            shape: self.shape.clone(),
            online: self.online.flat.to_vec(),
            target: self.target.flat.to_vec(),
            first_moment: self.first_moment.to_vec(),
            second_moment: self.second_moment.to_vec(),
            steps: self.steps,
        }
    }
}
