//! In which order objects are brought to their targets, where any order will do.

use super::distances::{self, features};
#[cfg(feature = "train")]
use crate::env::EnvSpec;
use crate::env::{Permutation, SignedIndex};
use crate::goal::{Achieved, Desired};
#[cfg(feature = "train")]
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Predicts from distances which order of the objects succeeds most often, by linear least squares
/// on how episodes ended.
///
/// A critic cannot tell: its values are discounted, and what an order costs comes late.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OrderModel {
    /// How near counts as placed, in meters.
    pub(crate) tolerance: f32,
    /// The orders besides the given one.
    pub(crate) others: Vec<OtherOrder>,
    /// Of each number of [`features`].
    pub(crate) weights: Vec<f64>,
}

/// A [`Permutation`] of any number of objects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OtherOrder {
    pub(crate) order: Vec<usize>,
    pub(crate) observation: Vec<SignedIndex>,
}

/// How an episode of the whole task began, and whether it succeeded.
#[cfg(feature = "train")]
pub(crate) struct Attempt<const N: usize> {
    pub(crate) start: Achieved<N>,
    pub(crate) desired: Desired<N>,
    pub(crate) success: bool,
}

impl OrderModel {
    /// Whether environments like `spec` leave a choice.
    #[cfg(feature = "train")]
    pub(crate) fn applies<const N: usize>(spec: &EnvSpec<N>) -> bool {
        spec.any_order && !spec.permutations.is_empty()
    }

    /// A model of these attempts, each with its objects in the order in which it was played; `None`
    /// where too few of them succeeded or failed to tell.
    #[cfg(feature = "train")]
    pub(crate) fn fit<const N: usize>(
        spec: &EnvSpec<N>,
        attempts: impl Iterator<Item = Attempt<N>>,
    ) -> Option<Self> {
        /// Of successes and of failures.
        const FEWEST: usize = 50;
        /// The prior's weight in the sum of squares, in attempts.
        const RIDGE: f64 = 30.0;

        let tolerance = spec.tolerances.objects[0];
        let given: Vec<usize> = (0..N).collect();
        let (rows, outcomes): (Vec<_>, Vec<_>) = attempts
            .map(|Attempt { start, desired, success }| {
                (features(&start, &desired, &given, tolerance), f64::from(u8::from(success)))
            })
            .unzip();
        let successes = outcomes.iter().sum::<f64>() as usize;
        if successes.min(outcomes.len() - successes) < FEWEST {
            return None;
        }
        let attempts = rows.len() as f64;
        let mean_outcome = successes as f64 / attempts;
        let width = distances::count(N);
        let mean =
            |of: &dyn Fn(&[f64]) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / attempts;
        let means: Vec<f64> = (0..width).map(|index| mean(&|row| row[index])).collect();
        let squared = |x: f64| x * x;
        let variance = |index: usize| mean(&|row| squared(row[index] - means[index]));
        let variances: Vec<f64> = (0..width).map(variance).collect();

        // (XᵀX + ridge · diag(variance)) w = Xᵀy for centered X and y: the ridge is that of
        // features in units of their standard deviations. What never varies has no say.
        let mut squares = DMatrix::<f64>::zeros(width, width);
        let mut products = DVector::<f64>::zeros(width);
        let mut centered = vec![0.0; width];
        for (row, outcome) in rows.iter().zip(&outcomes) {
            for ((to, x), mean) in centered.iter_mut().zip(row).zip(&means) {
                *to = x - mean;
            }
            for (column, x) in centered.iter().enumerate() {
                products[column] += x * (outcome - mean_outcome);
                for (sum, y) in squares.column_mut(column).iter_mut().zip(&centered) {
                    *sum += x * y;
                }
            }
        }
        for (index, variance) in variances.iter().enumerate() {
            squares[(index, index)] += if *variance > 1e-12 { RIDGE * variance } else { 1.0 };
        }
        let solved = squares.cholesky()?.solve(&products);
        let weights: Vec<f64> = solved.iter().copied().collect();
        weights.iter().all(|weight| weight.is_finite()).then(|| Self {
            tolerance,
            others: spec.permutations.iter().map(OtherOrder::new).collect(),
            weights,
        })
    }

    /// The order that promises most at the beginning of an episode; `None` for the given one.
    pub(crate) fn choose<const N: usize>(
        &self,
        start: &Achieved<N>,
        desired: &Desired<N>,
    ) -> Option<Permutation<N>> {
        let score = |order: &[usize]| -> f64 {
            let features = features(start, desired, order, self.tolerance);
            features.iter().zip(&self.weights).map(|(x, weight)| x * weight).sum()
        };
        let given: Vec<usize> = (0..N).collect();
        let (mut best, mut best_score) = (None, score(&given));
        for other in &self.others {
            let score = score(&other.order);
            if score > best_score {
                (best, best_score) = (Some(other), score);
            }
        }
        best.map(OtherOrder::permutation)
    }

    /// Whether it fits observations of this width.
    pub(crate) fn fits(&self, observation: usize, objects: usize) -> bool {
        let fits = |other: &OtherOrder| {
            let mut sorted = other.order.clone();
            sorted.sort_unstable();
            sorted.iter().copied().eq(0..objects)
                && other.observation.len() == observation
                && other.observation.iter().all(|image| image.from < observation)
        };
        self.others.iter().all(fits)
            && self.weights.len() == distances::count(objects)
            && self.weights.iter().all(|weight| weight.is_finite())
            && self.tolerance.is_finite()
    }
}

impl OtherOrder {
    #[cfg(feature = "train")]
    fn new<const N: usize>(permutation: &Permutation<N>) -> Self {
        let Permutation { order, observation } = permutation;
        Self { order: order.to_vec(), observation: observation.clone() }
    }

    fn permutation<const N: usize>(&self) -> Permutation<N> {
        let mut order = [0; N];
        order.copy_from_slice(&self.order);
        Permutation { order, observation: self.observation.clone() }
    }
}
