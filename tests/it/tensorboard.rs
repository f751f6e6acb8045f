//! `rher train --tensorboard`, read by `TensorBoard`'s own package.

use crate::python;
use crate::support::{Rher, TINY, shell};
use serde_json::Value;

/// Steps and values of every tag, as `TensorBoard` reads them.
fn events(rher: &Rher, run: &str) -> Option<Value> {
    let python = python::python()?;
    let folder = rher.path(run).join("tensorboard");
    Some(serde_json::from_str(&python::run(python, "tensorboard_events.py", &[&folder])).unwrap())
}

fn assert_same(events: &Value, metrics: &[Value]) {
    for (tag, path) in [
        ("success_final", "/success_final"),
        ("success/2", "/success/1"),
        ("critic_loss", "/critic_loss"),
        ("acted/learner", "/acted/learner"),
        ("guide", "/guide"),
    ] {
        let points = events[tag].as_array().unwrap_or_else(|| panic!("no `{tag}`: {events}"));
        assert_eq!(points.len(), metrics.len(), "{tag}: {points:?}");
        for (point, metrics) in points.iter().zip(metrics) {
            assert_eq!(point[0], metrics["env_steps"], "{tag}");
            let [read, written] = [&point[1], metrics.pointer(path).unwrap()].map(Value::as_f64);
            let [read, written] = [read, written].map(|number| number.unwrap() as f32);
            assert_eq!(read.to_bits(), written.to_bits(), "{tag}: {read} is not {written}");
        }
    }
}

#[test]
fn tensorboard_reads_what_metrics_say_also_of_a_run_that_went_on() {
    let rher = Rher::new();
    rher.ok(&format!("train push {TINY} --env-steps 1000 --out run --quiet --tensorboard"));
    let Some(first) = events(&rher, "run") else { return };
    let metrics = rher.metrics("run");
    assert!(metrics.len() > 2);
    assert_same(&first, &metrics);

    rher.ok("train --resume run --env-steps 2000 --quiet --tensorboard");
    let more = rher.metrics("run");
    assert!(more.len() > metrics.len());
    assert_same(&events(&rher, "run").unwrap(), &more);
}

/// Files are read in the order of their names, which begin with the time.
#[test]
fn a_clock_that_goes_back_hides_nothing() {
    let rher = Rher::new();
    rher.ok(&format!("train push {TINY} --env-steps 1000 --out run --quiet --tensorboard"));
    // As if the first part had been trained ten days later.
    let folder = rher.path("run/tensorboard");
    let file = std::fs::read_dir(&folder).unwrap().next().unwrap().unwrap();
    let name = file.file_name().into_string().unwrap();
    let seconds: u64 = name.split('.').nth(3).unwrap().parse().unwrap();
    let later = name.replace(&seconds.to_string(), &(seconds + 864_000).to_string());
    std::fs::rename(file.path(), folder.join(later)).unwrap();

    rher.ok("train --resume run --env-steps 2000 --quiet --tensorboard");
    let Some(events) = events(&rher, "run") else { return };
    assert_same(&events, &rher.metrics("run"));
}

#[test]
fn training_continues_without_event_files_that_cannot_be_written() {
    let rher = Rher::new();
    std::fs::create_dir_all(rher.path("run/tensorboard")).unwrap();
    let small = "mount -t tmpfs -o size=4k none run/tensorboard";
    if shell(&rher, &format!("unshare -m sh -c '{small}'")).status != Some(0) {
        python::ignored("a full disk takes the right to mount one");
        return;
    }
    let train = format!("train reach --env-steps 5000 --tensorboard --out run {TINY}");
    let ran = shell(&rher, &format!("unshare -m sh -c '{small}; exec \"$RHER\" {train}'"));
    assert_eq!(ran.status, Some(0), "{ran}");
    assert_eq!(
        ran.stderr.matches("event files have stopped, training continues").count(),
        1,
        "{ran}"
    );
    assert_eq!(rher.metrics("run").last().unwrap()["env_steps"], 5000);
}

#[test]
fn without_the_option_there_are_no_event_files() {
    let rher = Rher::new();
    rher.ok(&format!("train reach {TINY} --env-steps 500 --out run --quiet"));
    assert!(!rher.path("run").join("tensorboard").exists());
}
