//! Who acts in training.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rher_core::config::Preset;
use rher_core::explore::{ActionSource, Curriculum, Explorer};
use rher_core::goal::Stage;

/// However long random actions are kept, everyone acts in the share of steps that is set.
#[test]
fn everyone_acts_as_often_as_set() {
    for random_steps in [1.0, 4.0] {
        let mut config = Preset::Paper.config("shares", 1);
        config.exploration.random_steps = random_steps;
        let guide = Explorer::new(&config, 2, &Curriculum::new(&config.exploration, 2));
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let (mut counts, mut drawn) = ([0_u32; 3], 0);
        let mut last = ActionSource::Learner;
        for _ in 0..100_000 {
            if last != ActionSource::Random || !guide.keeps_random(&mut rng) {
                last = guide.draw(Stage::<1>::FIRST, &mut rng).source;
                drawn += u32::from(last == ActionSource::Random);
            }
            counts[last as usize] += 1;
        }
        let [guided, learned, random] = counts.map(|count| f64::from(count) / 100_000.0);
        let near = |share: f64, expected: f64| (share - expected).abs() < 0.01;
        assert!(near(guided, 0.4) && near(learned, 0.4) && near(random, 0.2), "{counts:?}");
        let kept_for = f64::from(counts[2]) / f64::from(drawn);
        assert!((kept_for / f64::from(random_steps) - 1.0).abs() < 0.05, "{kept_for} steps");
    }
}
