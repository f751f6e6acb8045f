//! What earlier versions wrote is read: `tests/data/run-VERSION` is a run of each.

use crate::support::Rher;
use std::fs;
use std::path::Path;

/// A copy of a kept run.
fn kept(rher: &Rher, version: &str) -> String {
    let name = format!("run-{version}");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(&name);
    for folder in ["", "checkpoint"] {
        fs::create_dir_all(rher.path(&name).join(folder)).unwrap();
        for entry in fs::read_dir(from.join(folder)).unwrap().map(Result::unwrap) {
            if entry.file_type().unwrap().is_file() {
                let to = rher.path(&name).join(folder).join(entry.file_name());
                fs::copy(entry.path(), to).unwrap();
            }
        }
    }
    name
}

#[test]
fn a_run_of_0_1_0_is_judged_and_resumed() {
    let rher = Rher::new();
    let run = kept(&rher, "0.1.0");
    let judged: serde_json::Value =
        serde_json::from_str(&rher.ok(&format!("eval {run} --episodes 3 --json"))).unwrap();
    assert!(judged["success_final"].is_number(), "{judged}");
    rher.ok(&format!("stats {run}"));
    let before = rher.metrics(&run);
    rher.ok(&format!("train --resume {run} --env-steps 500 --quiet"));
    let after = rher.metrics(&run);
    assert_eq!(before, after[..before.len()], "what was is kept");
    assert_eq!(after.last().unwrap()["env_steps"], 500);
}
