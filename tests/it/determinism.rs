//! One seed, one result.

use crate::support::{Rher, TINY};

#[test]
fn the_number_of_workers_changes_nothing() {
    let rher = Rher::new();
    let run = format!("train push --quiet --envs 3 --env-steps 1500 {TINY}");
    rher.ok(&format!("{run} --workers 1 --out one"));
    rher.ok(&format!("{run} --workers 2 --out two"));
    let metrics = rher.metrics("one");
    assert_eq!(metrics.len(), 6, "one whenever five more episodes are full");
    assert_eq!(metrics, rher.metrics("two"));
    let policy = |run: &str| std::fs::read(rher.path(run).join("policy.safetensors")).unwrap();
    assert_eq!(policy("one"), policy("two"));
}

#[test]
fn another_seed_is_another_run() {
    let rher = Rher::new();
    let run = format!("train push --quiet --env-steps 250 {TINY}");
    rher.ok(&format!("{run} --seed 1"));
    rher.ok(&format!("{run} --seed 2"));
    let last = |run: &str| rher.metrics(run).pop().unwrap();
    assert_ne!(last("runs/push-rher-fast-1"), last("runs/push-rher-fast-2"));
}
