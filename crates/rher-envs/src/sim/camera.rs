//! A camera that sees where things are, late and not quite.

use rand::{Rng, RngExt as _};
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::Vector;

/// The longest that a camera is late, in steps.
pub(crate) const LONGEST_DELAY: usize = 8;

/// What a camera sees of a few things.
#[derive(Clone)]
pub(super) struct Camera {
    /// Standard deviation of each coordinate, in meters.
    noise: f32,
    /// Steps by which it is late.
    delay: usize,
    rng: ChaCha8Rng,
    things: Vec<Thing>,
}

/// One thing before a camera.
#[derive(Clone)]
struct Thing {
    /// Where it was, the newest first.
    past: [Vector; LONGEST_DELAY + 1],
    /// Where it is seen, now and a step before.
    seen: [Vector; 2],
}

impl Camera {
    /// A camera that looks at things that have been at rest at `positions`.
    pub(super) fn new(
        noise: f32,
        delay: usize,
        rng: ChaCha8Rng,
        positions: impl Iterator<Item = Vector>,
    ) -> Self {
        let at_rest = |position| Thing { past: [position; LONGEST_DELAY + 1], seen: [position; 2] };
        let things = positions.map(at_rest).collect();
        let mut camera = Self { noise, delay: delay.min(LONGEST_DELAY), rng, things };
        for thing in &mut camera.things {
            thing.seen = [thing.past[0] + blur(camera.noise, &mut camera.rng); 2];
        }
        camera
    }

    /// Looks at things that are now at `positions`.
    pub(super) fn look(&mut self, positions: impl Iterator<Item = Vector>) {
        for (thing, position) in self.things.iter_mut().zip(positions) {
            thing.past.rotate_right(1);
            thing.past[0] = position;
            let seen = thing.past[self.delay] + blur(self.noise, &mut self.rng);
            thing.seen = [seen, thing.seen[0]];
        }
    }

    /// Where it sees a thing, and by how much that differs from a step before.
    pub(super) fn sees(&self, thing: usize) -> (Vector, Vector) {
        let [now, before] = self.things[thing].seen;
        (now, now - before)
    }
}

/// Noise with this standard deviation along each axis: nearly Gaussian, and the same on every
/// platform.
fn blur(deviation: f32, rng: &mut impl Rng) -> Vector {
    const SUMMANDS: usize = 12;
    let mut draw = || {
        let sum: f32 = (0..SUMMANDS).map(|_| rng.random::<f32>()).sum();
        deviation * (sum - SUMMANDS as f32 / 2.0)
    };
    Vector::new(draw(), draw(), draw())
}
