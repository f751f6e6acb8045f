//! `rher stats`, on runs whose numbers are known.

use crate::support::Rher;
use insta::assert_snapshot;
use serde_json::{Value, json};

/// Makes a run folder with one evaluation every 2,500 steps and 10 seconds.
pub(crate) fn run(rher: &Rher, name: &str, method: &str, seed: u64, success: &[f32]) {
    std::fs::create_dir(rher.path(name)).unwrap();
    let config = format!(
        "task = \"push\"\npreset = \"fast\"\nseed = {seed}\n[relay]\nmethod = \"{method}\"\n"
    );
    rher.write(&format!("{name}/config.toml"), config);
    let lines = success.iter().enumerate().map(|(index, rate)| {
        let line = json!({
            "env_steps": 2500 * (index + 1),
            "wall_s": 10.0 * (index + 1) as f64,
            "success": [Value::Null, rate],
            "success_final": rate,
        });
        line.to_string() + "\n"
    });
    rher.write(&format!("{name}/metrics.jsonl"), lines.collect::<String>());
}

pub(crate) fn three_and_one() -> Rher {
    let rher = Rher::new();
    run(&rher, "a1", "rher", 1, &[0.1, 0.6, 0.95, 0.97]);
    run(&rher, "a2", "rher", 2, &[0.2, 0.5, 0.85, 0.99]);
    run(&rher, "a3", "rher", 3, &[0.1, 0.2, 0.85, 0.9]);
    run(&rher, "b1", "her", 1, &[0.1, 0.1, 0.1, 0.1, 0.2]);
    rher
}

#[test]
fn stats_say_how_soon_how_often_and_how_sure() {
    let rher = three_and_one();
    assert_snapshot!(rher.ok("stats a1 b1 a2 a3"), @"
    Success at the last evaluation

    task  method  preset  runs  final success      interquartile mean
    push  rher    fast    3     95 % [90 %, 99 %]  95 % [90 %, 99 %]
    push  her     fast    1     20 %               20 %

    Environment steps to the first evaluation of

    task  method  preset  50 %                  80 %                  90 %                    95 %
    push  rher    fast    5,000 [5,000, 7,500]  7,500 [7,500, 7,500]  10,000 [7,500, 10,000]  10,000 [7,500, never] (2 of 3)
    push  her     fast    never                 never                 never                   never

    Wall clock to the first evaluation of

    task  method  preset  50 %               80 %               90 %               95 %
    push  rher    fast    20 s [20 s, 30 s]  30 s [30 s, 30 s]  40 s [30 s, 40 s]  40 s [30 s, never] (2 of 3)
    push  her     fast    never              never              never              never

    Probability of improvement

    task  a run of   better than one of  higher final success  95 % in fewer steps  95 % in less time
    push  rher fast  her fast            100 %                 83 %                 83 %

    In brackets: 95 % bootstrap intervals over runs, where there are several. Times are those of the median run.
    ");
}

#[test]
fn stats_repeat_and_are_told_in_markdown_and_json() {
    let rher = three_and_one();
    let markdown = rher.ok("stats a1 a2 b1 --markdown");
    assert!(markdown.contains("| task | method | preset |"), "{markdown}");
    let text = rher.ok("stats a1 a2 a3 b1 --json");
    assert_eq!(text, rher.ok("stats a1 a2 a3 b1 --json"));
    let stats: Value = serde_json::from_str(&text).unwrap();
    let [rher, her] = [0, 1].map(|group| &stats["groups"][group]);
    assert_eq!(rher["seeds"], json!([1, 2, 3]));
    assert_eq!(rher["reached"][3]["rate"], 0.95);
    assert_eq!(rher["reached"][3]["runs"], 2);
    assert_eq!(rher["reached"][3]["env_steps"]["value"], 10_000.0);
    assert_eq!(rher["reached"][3]["wall_s"]["value"], 40.0);
    assert_eq!(her["reached"][0]["env_steps"]["value"], Value::Null);
    assert_eq!(her["success_final"]["ci95"], Value::Null);
    assert_eq!(stats["comparisons"][0]["success_final"]["value"], 1.0);
}

#[test]
fn what_is_no_run_is_told_with_a_way_out() {
    let rher = three_and_one();
    assert_snapshot!(rher.run("stats a1 nowhere"), @"
    exit 5
    error: `nowhere` holds no run: there is no `config.toml` in it

    hint: give a folder that `rher train` made: it has `config.toml` and `metrics.jsonl`
    ");
    rher.write("a2/metrics.jsonl", "");
    assert_snapshot!(rher.run("stats a2"), @"
    exit 5
    error: `a2/metrics.jsonl` has no metrics yet: expected a line for each evaluation

    hint: wait for its first evaluation, or leave this run out
    ");
    rher.write("a3/metrics.jsonl", "{\"env_steps\": 1}\n");
    assert_snapshot!(rher.run("stats a3"), @"
    exit 8
    error: line 1 of `a3/metrics.jsonl` is damaged: missing field `wall_s` at line 1 column 16

    hint: restore the file, or leave this run out
    ");
    assert_eq!(rher.run("stats").status, Some(2));
}

#[test]
fn a_line_that_is_being_written_is_not_read() {
    let rher = three_and_one();
    let whole = rher.ok("stats a1");
    let path = rher.path("a1/metrics.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text + "{\"env_st").unwrap();
    assert_eq!(rher.ok("stats a1"), whole);
}
