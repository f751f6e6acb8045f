//! Policies on their way to others: as ONNX models, which Python runs in its tests, and with cards.

use crate::python::{self, python};
use crate::support::{Rher, TINY};
use serde_json::Value;
use sha2::{Digest as _, Sha256};

fn sha256(file: &[u8]) -> String {
    format!("{:x}", Sha256::digest(file))
}

#[test]
fn a_model_has_a_contract_beside_it() {
    let rher = Rher::new();
    rher.ok(&format!("train push --env-steps 1 --out run {TINY}"));
    let ran = rher.run("export run --format onnx");
    assert!(ran.stderr.contains("`policy.onnx` and `policy.json`"), "{ran}");
    let model = std::fs::read(rher.path("policy.onnx")).unwrap();
    let contract: Value =
        serde_json::from_slice(&std::fs::read(rher.path("policy.json")).unwrap()).unwrap();
    assert_eq!(contract["task"], "push");
    assert_eq!(contract["rate_hz"], 25.0);
    assert_eq!(contract["objects"], serde_json::json!(["block1"]));
    assert_eq!(contract["model"]["file"], "policy.onnx");
    assert_eq!(contract["model"]["sha256"], sha256(&model));
    let policy = std::fs::read(rher.path("run/policy.safetensors")).unwrap();
    assert_eq!(contract["policy"]["sha256"], sha256(&policy));
    for input in contract["inputs"].as_array().unwrap() {
        for list in ["names", "units"] {
            assert_eq!(input[list].as_array().unwrap().len(), input["shape"][1], "{input}");
        }
    }
    rher.ok("export run/policy.safetensors --format onnx --out file.onnx");
    assert_eq!(std::fs::read(rher.path("file.onnx")).unwrap(), model);
    rher.ok("export tpush --format onnx --out shipped.onnx");
}

#[test]
fn what_is_no_policy_is_not_exported() {
    let rher = Rher::new();
    rher.write("text.mcap", "not a policy, and no recording either");
    for (arguments, status, problem) in [
        ("nowhere --format onnx", 5, "cannot read `nowhere`"),
        ("text.mcap --format onnx", 8, "`text.mcap` is not a policy file"),
        ("push --format onnx --out push.pb", 2, "expected a name that ends in .onnx"),
        ("push --format onnx --out no/where/push.onnx", 6, "push.onnx"),
        ("push --format onnx --episodes 3", 2, "`--episodes` is for datasets"),
        ("push --format onnx --seed 3", 2, "`--seed` is for datasets"),
        ("push --format onnx --dataset-id rher/push-v0", 2, "`--dataset-id` is for datasets"),
        ("push --format minari", 2, "--out <OUT>"),
    ] {
        let ran = rher.run(&format!("export {arguments}"));
        assert_eq!(ran.status, Some(status), "{arguments}: {ran}");
        assert!(ran.stderr.contains(problem), "{arguments}: {ran}");
    }
    assert_eq!(std::fs::read_dir(rher.path("")).unwrap().count(), 1);
}

#[test]
fn a_card_is_as_the_hub_reads_it() {
    let rher = Rher::new();
    rher.ok(&format!("train push --env-steps 1 --out run {TINY}"));
    rher.ok("card run -o push-card --episodes 7");
    let page = std::fs::read_to_string(rher.path("push-card/README.md")).unwrap();
    for name in ["policy.safetensors", "config.toml", "metrics.jsonl", "episode.gif"] {
        let hash = sha256(&std::fs::read(rher.path("push-card").join(name)).unwrap());
        assert!(page.contains(&format!("| `{name}` | `{hash}` |")), "{page}");
    }
    let judged = "eval . --episodes 7 --seed 1";
    assert!(page.contains(&format!("$ rher {judged}\n")), "{page}");
    let measured = rher.ok(&judged.replace('.', "push-card"));
    assert!(page.contains(measured.trim_end()), "{measured}{page}");
    let ran = rher.run("card run -o push-card --episodes 7");
    assert_eq!(ran.status, Some(6), "{ran}");
    assert!(ran.stderr.contains("`push-card` exists already"), "{ran}");
    let Some(python) = python() else { return };
    let read = python::run(python, "model_card.py", &[&rher.path("push-card")]);
    let card: Value = serde_json::from_str(read.lines().last().unwrap()).unwrap();
    assert_eq!(card["library_name"], "rher");
    assert_eq!(card["results"][0]["dataset_type"], "rher/push");
    let rate: Value = serde_json::from_str(&rher.ok("eval run --episodes 7 --json")).unwrap();
    let [given, measured] = [&card["results"][0]["metric_value"], &rate["success_final"]];
    assert_eq!(given.as_f64(), measured.as_f64());
    assert!(given.is_number());
}
