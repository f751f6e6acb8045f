//! Programs with tasks of their own, as docs/adding-a-task.md makes them.

use crate::support::{Ran, Rher, TINY};
use std::path::Path;
use std::process::Command;

const PAGE: &str = include_str!("../../docs/adding-a-task.md");
const TASK: &str = include_str!("../../crates/rher-cli/examples/corner/corner.rs");
const PROGRAM: &str = include_str!("../../crates/rher-cli/examples/corner/main.rs");

#[test]
fn the_page_shows_the_program_that_is_tested_here() {
    assert!(PAGE.contains(&format!("```rust\n{TASK}")));
    assert!(PAGE.contains(&format!("```rust,ignore\n{PROGRAM}```")));
    let manifest = PAGE.split_once("```toml\n").unwrap().1.split_once("```").unwrap().0;
    let manifest: toml::Table = manifest.parse().unwrap();
    let workspace: toml::Table = include_str!("../../Cargo.toml").parse().unwrap();
    let package = &workspace["workspace"]["package"];
    assert_eq!(manifest["package"]["edition"], package["edition"]);
    for (name, dependency) in manifest["dependencies"].as_table().unwrap() {
        let ours = &workspace["workspace"]["dependencies"][name];
        if let Some(path) = dependency.get("path") {
            assert_eq!(
                path.as_str().unwrap(),
                format!("../rher/{}", ours["path"].as_str().unwrap())
            );
        } else {
            let ours = ours["version"].as_str().unwrap();
            assert!(ours.starts_with(dependency.as_str().unwrap()), "{name}");
        }
    }
}

#[test]
fn a_task_of_a_program_of_its_own_gets_everything() {
    let rher = Rher::new();
    let corner = |arguments: &str| example("corner", &rher, arguments);
    let ok = |arguments: &str| {
        let ran = corner(arguments);
        assert_eq!(ran.status, Some(0), "`corner {arguments}`:\n{ran}");
        ran.to_string()
    };
    assert!(ok("tasks").contains("corner") && ok("tasks").contains("tstack"));
    let log = ok(&format!("train corner --env-steps 500 {TINY} --out runs/corner"));
    assert!(log.contains("`corner play runs/corner "), "{log}");
    ok("train --resume runs/corner --env-steps 1k");
    ok("eval runs/corner --episodes 3");
    ok("play runs/corner --episodes 1 --gif corner.gif --mcap corner.mcap");
    assert!(ok("replay corner.mcap --verify").contains("`corner` reproduce bit for bit"));
    ok("export corner.mcap --format minari --out corner-minari");
    let sweep =
        format!("sweep corner --seeds 1-2 --env-steps 300 {TINY} --plan plan.jsonl --out swept");
    ok(&sweep);
    ok("sweep --plan plan.jsonl");
    ok("sweep --status plan.jsonl");
    ok("stats plan.jsonl");
    ok("report runs/corner -o corner.html");
    assert!(rher.path("corner.html").exists() && rher.path("corner.gif").exists());

    assert!(ok("--help").contains("Start with `corner play stack"));
    assert!(ok("eval --help").contains("  corner eval runs/"));

    let foreign = rher.run("eval runs/corner").to_string();
    assert!(foreign.contains("`corner`, which is not part of this program"), "{foreign}");
}

#[test]
fn an_environment_without_rapier_is_a_task_too() {
    let rher = Rher::new();
    let line = |arguments: &str| example("line", &rher, arguments);
    for arguments in [
        &format!("train line --env-steps 200 {TINY} --out run"),
        "train --resume run --env-steps 400",
        "eval run --episodes 3",
        "play run --episodes 1 --mcap line.mcap",
        "replay line.mcap --verify",
        &format!("sweep line --seeds 1-2 --env-steps 200 {TINY} --out swept"),
        "report run -o line.html",
    ] {
        let ran = line(arguments);
        assert_eq!(ran.status, Some(0), "`line {arguments}`:\n{ran}");
    }
    let ran = line("train line --set randomize.friction=[0.5,2]").to_string();
    assert!(ran.contains("environments of this task randomize nothing"), "{ran}");
    let ran = line("play run --film line.gif").to_string();
    assert!(ran.contains("cannot be drawn") && !rher.path("line.gif").exists(), "{ran}");
    // What is not known here is left out of a page.
    rher.ok("report run -o line.html");
}

/// An example of this crate in the folder of a test; Cargo builds it where it builds all tests.
fn example(name: &str, rher: &Rher, arguments: &str) -> Ran {
    let program = Path::new(env!("CARGO_BIN_EXE_rher")).with_file_name("examples").join(name);
    assert!(program.exists(), "`cargo build --release -p rher-cli --examples` makes {name}");
    let mut command = Command::new(program);
    command.current_dir(rher.path("")).args(arguments.split_whitespace()).output().unwrap().into()
}
