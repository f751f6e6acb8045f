//! Normal draws whose bits do not depend on the C library.
//!
//! The one of `rand_distr` takes its exponential and logarithm from there as soon as any crate of
//! the program enables `std` of `num-traits`.

use rand::{Rng, RngExt as _, distr::Distribution};
use std::sync::LazyLock;

/// Layers of equal area that cover the density.
const LAYERS: usize = 256;
/// Where the tail begins, for this number of layers.
const TAIL: f64 = 3.654_152_885_361_009;

/// The standard normal distribution, by the ziggurat method (Doornik, "An improved ziggurat method
/// to generate normal random samples", 2005).
#[derive(Clone, Copy, Debug)]
pub struct StandardNormal;

/// Right ends of the layers from the tail upwards and their densities, both up to the peak.
struct Ziggurat {
    ends: [f64; LAYERS + 1],
    densities: [f64; LAYERS + 1],
}

static ZIGGURAT: LazyLock<Ziggurat> = LazyLock::new(|| {
    let tail_area = (std::f64::consts::PI / 2.0).sqrt() * libm::erfc(TAIL / 2_f64.sqrt());
    let area = TAIL * density(TAIL) + tail_area;
    let mut ends = [0.0; LAYERS + 1];
    // As if the lowest layer, with the tail, was a rectangle.
    ends[0] = area / density(TAIL);
    ends[1] = TAIL;
    for index in 2..LAYERS {
        let below: f64 = ends[index - 1];
        ends[index] = (-2.0 * libm::log(area / below + density(below))).sqrt();
    }
    Ziggurat { densities: ends.map(density), ends }
});

/// Up to a factor.
fn density(x: f64) -> f64 {
    libm::exp(-0.5 * x * x)
}

impl Distribution<f32> for StandardNormal {
    fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f32 {
        const UNIT: f64 = 1.0 / (1_u64 << 52) as f64;
        let Ziggurat { ends, densities } = &*ZIGGURAT;
        loop {
            let bits = rng.next_u64();
            let layer = bits as usize % LAYERS;
            // The layer has the bits below; these are the 53 above, from −1 to 1.
            let x = ((bits >> 11) as f64 * UNIT - 1.0) * ends[layer];
            if x.abs() < ends[layer + 1] {
                return x as f32;
            }
            if layer == 0 {
                return tail(rng).copysign(x) as f32;
            }
            let (low, high) = (densities[layer], densities[layer + 1]);
            if low + (high - low) * rng.random::<f64>() < density(x) {
                return x as f32;
            }
        }
    }
}

/// A draw from beyond [`TAIL`].
fn tail(rng: &mut (impl Rng + ?Sized)) -> f64 {
    loop {
        // From 0, excluded, to 1.
        let [first, second] = rng.random::<[f64; 2]>().map(|x| libm::log(1.0 - x));
        let beyond = -first / TAIL;
        if -2.0 * second > beyond * beyond {
            return TAIL + beyond;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn layers_have_the_same_area_and_end_at_the_peak() {
        let Ziggurat { ends, densities } = &*ZIGGURAT;
        let area = ends[0] * densities[1];
        for layer in 1..LAYERS {
            let found = ends[layer] * (densities[layer + 1] - densities[layer]);
            assert!((found / area - 1.0).abs() < 1e-7, "layer {layer}: {found} and not {area}");
        }
    }

    #[test]
    fn shares_below_any_number_are_those_of_the_distribution() {
        const DRAWS: usize = 10_000_000;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut draws: Vec<f32> = (0..DRAWS).map(|_| StandardNormal.sample(&mut rng)).collect();
        draws.sort_unstable_by(f32::total_cmp);
        for tenth in -50..=50_i32 {
            let x = f64::from(tenth) / 10.0;
            let share = draws.partition_point(|draw| f64::from(*draw) < x) as f64 / DRAWS as f64;
            let expected = 0.5 * libm::erfc(-x / 2_f64.sqrt());
            let deviation = (expected * (1.0 - expected) / DRAWS as f64).sqrt();
            let error = (share - expected) / deviation;
            assert!(error.abs() < 4.5, "below {x}: {share} and not {expected}, {error} deviations");
        }
    }
}
