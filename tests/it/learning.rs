//! Short runs of the real thing: sparse reward, real scenes, the default settings.

use crate::support::Rher;

#[test]
fn reach_is_learned_within_5000_steps() {
    let rher = Rher::new();
    rher.ok("train reach --env-steps 5000 --out run --quiet");
    let last = rher.metrics("run").pop().unwrap();
    assert_eq!(last["success_final"], 1.0, "{last}");
}

/// Plain hindsight stays at the share of episodes that begin solved, 7 %.
#[test]
fn push_is_half_learned_within_20000_steps() {
    let rher = Rher::new();
    rher.ok("train push --env-steps 20000 --out run --quiet");
    let last = rher.metrics("run").pop().unwrap();
    assert!(last["success_final"].as_f64().unwrap() >= 0.5, "{last}");
}
