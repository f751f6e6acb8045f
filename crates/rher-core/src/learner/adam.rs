//! What moves parameters: Adam for the trained ones, a slow pursuit for the targets.
//!
//! Each closure given to `dispatch` consumes an iterator: one that consumes nothing is called
//! through a shim, and not compiled for the wider registers.

use super::engine::{BETA_1, BETA_2, EPSILON};
use super::state::Trained;
use pulp::Arch;

impl Trained {
    /// One Adam step against `gradient`, which has the layout of the parameters.
    ///
    /// The rule is PyTorch's: θ ← θ − rate · m̂ / (√v̂ + ε), with both moments corrected for their
    /// start at zero.
    pub fn descend(&mut self, gradient: &[f32], learning_rate: f32) {
        self.steps += 1;
        let missing = |beta: f32| 1.0 - f64::from(beta).powf(self.steps as f64);
        let rate = (f64::from(learning_rate) / missing(BETA_1)) as f32;
        let root = missing(BETA_2).sqrt() as f32;
        let parameters = self.online.iter_mut().zip(gradient);
        let moments = self.first_moment.iter_mut().zip(&mut self.second_moment);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for ((parameter, &slope), (first, second)) in parameters.zip(moments) {
                    *first += (1.0 - BETA_1) * (slope - *first);
                    *second = BETA_2 * *second + (1.0 - BETA_2) * slope * slope;
                    *parameter -= rate * *first / (second.sqrt() / root + EPSILON);
                }
            },
        );
    }

    /// Moves the target by the share `rate` of its distance to the trained parameters.
    pub fn follow(&mut self, rate: f32) {
        let pairs = self.target.iter_mut().zip(&self.online);
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for (target, online) in pairs {
                    *target += rate * (online - *target);
                }
            },
        );
    }
}

/// Sum of squares, in an order that does not depend on the processor.
pub(super) fn squared_norm(values: &[f32]) -> f32 {
    const LANES: usize = 32;
    let (chunks, rest) = values.as_chunks::<LANES>();
    let chunks = chunks.iter();
    let sums = Arch::new().dispatch(
        #[inline(always)]
        || {
            let mut sums = [0.0; LANES];
            for chunk in chunks {
                for (sum, value) in sums.iter_mut().zip(chunk) {
                    *sum += value * value;
                }
            }
            sums
        },
    );
    sums.into_iter().chain(rest.iter().map(|value| value * value)).sum()
}

#[cfg(test)]
mod tests {
    use super::super::network::Shape;
    use super::*;

    #[test]
    fn five_steps_are_those_of_the_rule_in_f64() {
        let shape = Shape { inputs: 40, hidden: vec![], outputs: 1, layer_norm: false };
        let online: Vec<f32> = (0..41).map(|index| (index as f32).sin()).collect();
        let mut trained = Trained {
            shape,
            target: online.clone(),
            first_moment: vec![0.0; 41],
            second_moment: vec![0.0; 41],
            online,
            steps: 0,
        };
        let mut expected: Vec<_> =
            trained.online.iter().map(|start| (f64::from(*start), 0.0, 0.0)).collect();
        for step in 1..=5 {
            // Over many orders of magnitude, to tell where ε is added.
            let slope = |index: usize| {
                (step as f32 * index as f32).cos() * 0.1_f32.powf(index as f32 / 4.0)
            };
            trained.descend(&(0..41).map(slope).collect::<Vec<_>>(), 1e-2);
            for (index, (parameter, first, second)) in expected.iter_mut().enumerate() {
                let slope = f64::from(slope(index));
                *first = 0.9 * *first + 0.1 * slope;
                *second = 0.999 * *second + 0.001 * slope * slope;
                let mean = *first / (1.0 - 0.9_f64.powi(step));
                let square: f64 = *second / (1.0 - 0.999_f64.powi(step));
                *parameter -= 1e-2 * mean / (square.sqrt() + 1e-8);
            }
        }
        assert_eq!(trained.steps, 5);
        for (online, (expected, ..)) in trained.online.iter().zip(expected) {
            assert!((f64::from(*online) - expected).abs() < 1e-6, "{online} is not {expected}");
        }
    }

    #[test]
    fn the_norm_counts_what_is_left_of_the_last_chunk() {
        assert_eq!(squared_norm(&[2.0; 67]).to_bits(), 268.0_f32.to_bits());
    }
}
