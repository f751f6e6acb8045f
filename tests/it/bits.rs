//! Short runs of three tasks end with the bits that they always had, by all instructions.

use crate::support::Rher;
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;

/// Task, hash of the tensors in `policy.safetensors`, hash of `metrics.jsonl` without wall clocks.
/// A change that moves one of these numbers changes what is learned from a seed: say so in the
/// change log.
const HASHES: &[(&str, &str, &str)] = &[
    ("push", "cbeb5df3221a513c", "5dd3e8ed4b1e0758"),
    ("dpush", "e4e916ceb20a1ecf", "60da181761502deb"),
    ("drawer-box", "58a5002fea52cdec", "ebb965978c791db7"),
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
        let lines = rher.metrics(task).iter().map(ToString::to_string).collect::<Vec<_>>();
        assert!(lines.len() > 1, "evaluations");
        let found = (task, tensors(&rher, task), hash(lines.join("\n").as_bytes()));
        if !HASHES.contains(&(found.0, found.1.as_str(), found.2.as_str())) {
            writeln!(wrong, "    {found:?},").unwrap();
        }
    }
    assert!(wrong.is_empty(), "missing from HASHES or changed:\n{wrong}");
}

/// A smaller run, because the portable loops take a hundred times as long for their products.
#[test]
fn every_set_of_instructions_trains_the_same_policy() {
    let rher = Rher::new();
    let train = |simd: &str| {
        let run = format!(
            "train dpush --seed 1 --env-steps 300 --until 0 --quiet --workers 2 --out {simd} \
             --set agent.hidden=[100,64] --set replay.batch_size=100 \
             --set replay.updates_per_episode=40 --set evaluation.episodes=5"
        );
        let output = rher.command(&run).env("RHER_SIMD", simd).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), error)
    };
    let (status, error) = train("none-of-these");
    assert_eq!(status, Some(2));
    assert!(error.contains("`none-of-these`") && error.contains("portable"), "{error}");

    assert_eq!(train("portable"), (Some(0), String::new()));
    let expected = tensors(&rher, "portable");
    for simd in ["avx512", "avx2", "neon"] {
        if error.contains(simd) {
            assert_eq!(train(simd), (Some(0), String::new()));
            assert_eq!(tensors(&rher, simd), expected, "{simd} is not portable");
        }
    }
}

/// The hash of the tensors of a run's policy.
fn tensors(rher: &Rher, run: &str) -> String {
    let file = std::fs::read(rher.path(run).join("policy.safetensors")).unwrap();
    let (length, rest) = file.split_first_chunk().unwrap();
    hash(&rest[u64::from_le_bytes(*length) as usize..])
}

fn hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().take(8).fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}
