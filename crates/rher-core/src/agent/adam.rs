//! What moves parameters: Adam for the trained ones, a slow pursuit for the targets.

use super::learner::{BETA_1, BETA_2, EPSILON, Trained};
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
pub fn squared_norm(values: &[f32]) -> f32 {
    const LANES: usize = 32;
    let (chunks, rest) = values.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for chunk in chunks {
                for (sum, value) in sums.iter_mut().zip(chunk) {
                    *sum += value * value;
                }
            }
        },
    );
    sums.iter().sum::<f32>() + rest.iter().map(|value| value * value).sum::<f32>()
}
