//! Running mean and standard deviation, and the clipped normalization they give.

use serde::{Deserialize, Serialize};

/// Normalized values are clipped to ± this.
pub const CLIP: f32 = 5.0;

/// Smallest standard deviation that is divided by.
pub const SMALLEST_DEVIATION: f32 = 0.01;

/// Running statistics of a vector, one mean and deviation for each of its numbers.
///
/// Positions around 1.3 m vary by centimeters, so the sums are kept in `f64`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Normalizer {
    count: f64,
    sums: Vec<f64>,
    squares: Vec<f64>,
    mean: Vec<f32>,
    inverse_deviation: Vec<f32>,
}

impl Normalizer {
    /// Statistics of nothing yet: values pass through, clipped.
    pub fn new(width: usize) -> Self {
        Self {
            count: 0.0,
            sums: vec![0.0; width],
            squares: vec![0.0; width],
            mean: vec![0.0; width],
            inverse_deviation: vec![1.0; width],
        }
    }

    /// Whether its parts fit a vector of `width` numbers and each other, which those of a damaged
    /// file may not.
    pub(super) fn is_consistent(&self, width: usize) -> bool {
        let lengths = [self.sums.len(), self.squares.len(), self.inverse_deviation.len()];
        let is_scale = |scale: &f32| scale.is_finite() && *scale > 0.0;
        self.mean.len() == width
            && lengths == [width; 3]
            && self.count >= 0.0
            && self.count.is_finite()
            && self.mean.iter().all(|mean| mean.is_finite())
            && self.inverse_deviation.iter().all(is_scale)
    }

    /// Numbers in a vector.
    pub fn width(&self) -> usize {
        self.mean.len()
    }

    /// What is subtracted from each number.
    #[cfg(feature = "onnx")]
    pub(crate) fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// What each difference is multiplied with.
    #[cfg(feature = "onnx")]
    pub(crate) fn inverse_deviation(&self) -> &[f32] {
        &self.inverse_deviation
    }

    /// Statistics of other vectors: each of `numbers` is what the numbers of this one at that place
    /// were, or is unknown and passes through as it did with as many values of mean 0 and deviation
    /// 1.
    #[cfg(feature = "train")]
    pub(super) fn rearranged(&self, numbers: &[Option<usize>]) -> Self {
        fn pick<T: Copy>(values: &[T], numbers: &[Option<usize>], unknown: T) -> Vec<T> {
            numbers.iter().map(|number| number.map_or(unknown, |number| values[number])).collect()
        }
        Self {
            count: self.count,
            sums: pick(&self.sums, numbers, 0.0),
            squares: pick(&self.squares, numbers, self.count),
            mean: pick(&self.mean, numbers, 0.0),
            inverse_deviation: pick(&self.inverse_deviation, numbers, 1.0),
        }
    }

    /// Takes a vector into the sums; [`Normalizer::refresh`] brings them into force.
    pub fn observe(&mut self, values: impl IntoIterator<Item = f32>) {
        self.count += 1.0;
        for ((sum, square), value) in self.sums.iter_mut().zip(&mut self.squares).zip(values) {
            let value = f64::from(value);
            *sum += value;
            *square += value * value;
        }
    }

    /// Recomputes means and deviations from the sums.
    pub fn refresh(&mut self) {
        if self.count == 0.0 {
            return;
        }
        let moments = self.sums.iter().zip(&self.squares);
        let outputs = self.mean.iter_mut().zip(&mut self.inverse_deviation);
        for ((sum, square), (mean, inverse)) in moments.zip(outputs) {
            let average = sum / self.count;
            let variance = (square / self.count - average * average).max(0.0);
            *mean = average as f32;
            *inverse = 1.0 / (variance.sqrt() as f32).max(SMALLEST_DEVIATION);
        }
    }

    /// Writes the normalized values.
    #[inline]
    pub fn apply(&self, values: impl IntoIterator<Item = f32>, normalized: &mut [f32]) {
        debug_assert_eq!(normalized.len(), self.width());
        let scales = self.mean.iter().zip(&self.inverse_deviation);
        for ((out, value), (mean, inverse)) in normalized.iter_mut().zip(values).zip(scales) {
            *out = ((value - mean) * inverse).clamp(-CLIP, CLIP);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_statistics_are_noticed() {
        assert!(Normalizer::new(3).is_consistent(3));
        assert!(!Normalizer::new(3).is_consistent(2));
        let damage: [fn(&mut Normalizer); 9] = [
            |it| it.inverse_deviation[1] = 0.0,
            |it| it.inverse_deviation[1] = -1.0,
            |it| it.inverse_deviation[1] = f32::INFINITY,
            |it| it.inverse_deviation.truncate(2),
            |it| it.mean[0] = f32::NAN,
            |it| it.sums.push(0.0),
            |it| it.squares.truncate(2),
            |it| it.count = -1.0,
            |it| it.count = f64::INFINITY,
        ];
        for (index, damage) in damage.iter().enumerate() {
            let mut statistics = Normalizer::new(3);
            damage(&mut statistics);
            assert!(!statistics.is_consistent(3), "damage {index}");
        }
    }
}
