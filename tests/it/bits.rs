//! Short runs of three tasks end with the bits that they always had.

use crate::support::Rher;
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;

/// Task, hash of the tensors in `policy.safetensors`, hash of `metrics.jsonl` without wall clocks;
/// by fused arithmetic, which the portable loops do not have. A change that moves one of these
/// numbers changes what is learned from a seed: say so in the change log.
const HASHES: &[(&str, &str, &str)] = &[
    ("push", "caf4e590e4f2e192", "fbaf83214c3653af"),
    ("dpush", "d2ea066477b751fe", "fd85b85178e1dfab"),
    ("drawer-box", "fa8a761d8c164192", "a4c66381c3ffb30c"),
];

#[test]
fn short_runs_end_with_the_bits_that_they_had() {
    let rher = Rher::new();
    let mut wrong = String::new();
    for task in ["push", "dpush", "drawer-box"] {
        rher.ok(&format!(
            "train {task} --seed 1 --env-steps 1200 --until 0 --quiet --out {task} \
             --set evaluation.every_episodes=5 --set evaluation.episodes=20 \
             --set evaluation.subtask_episodes=5"
        ));
        let file = std::fs::read(rher.path(task).join("policy.safetensors")).unwrap();
        let (length, rest) = file.split_first_chunk().unwrap();
        let tensors = hash(&rest[u64::from_le_bytes(*length) as usize..]);
        let lines = rher.metrics(task).iter().map(ToString::to_string).collect::<Vec<_>>();
        assert!(lines.len() > 1, "evaluations");
        let found = (task, tensors.as_str(), hash(lines.join("\n").as_bytes()));
        if !HASHES.contains(&(found.0, found.1, found.2.as_str())) {
            writeln!(wrong, "    {found:?},").unwrap();
        }
    }
    assert!(wrong.is_empty(), "missing from HASHES or changed:\n{wrong}");
}

fn hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().take(8).fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}
