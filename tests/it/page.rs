//! The commands of README.md work as they are written, in the order of the page.
//!
//! They are run in an empty folder by programs in front of the PATH that make what takes long short,
//! and leave the command as it is: `rher` adds `--env-steps 100` to what trains, and a task or a size
//! to what measures speed; `cargo` runs the program that Cargo has built for the tests, and `cargo`
//! and `pip` otherwise look only whether what is named is there.

use crate::support::{Ran, Rher};
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::{Command, Stdio};

const README: &str = include_str!("../../README.md");

const SHORT_RHER: &str = r#"#!/bin/sh
case "$1 $2" in
    "train --resume") exec "$RHER" "$@" ;;
    "train "* | "sweep "* | "reproduce "*) exec "$RHER" "$@" --env-steps 100 ;;
    "bench env") exec "$RHER" "$@" --task push ;;
    "bench update") exec "$RHER" "$@" --batch 128 --inputs 31 --threads 1 ;;
    *) exec "$RHER" "$@" ;;
esac
"#;

const SHORT_CARGO: &str = r#"#!/bin/sh
case "$*" in
    "run --release --bin rher -- "*) shift 5; exec rher "$@" ;;
    "run --release -p rher-core --example "*) test -e "$REPOSITORY/crates/rher-core/examples/$6.rs" ;;
    "install --path "*) test -e "$REPOSITORY/$3/Cargo.toml" ;;
    "test --release") ;;
    *) echo "the test of the page does not know 'cargo $*'" >&2; exit 1 ;;
esac
"#;

const SHORT_PIP: &str = r#"#!/bin/sh
test "$1" = install && test -e "$REPOSITORY/$2/pyproject.toml"
"#;

/// Prints its arguments, one on a line.
const ECHO: &str = "#!/bin/sh\nprintf '[%s]\\n' \"$@\"\n";

/// The commands of the page, in its order.
fn commands() -> Vec<&'static str> {
    let blocks = README.split("```console\n").skip(1);
    let blocks = blocks.map(|rest| rest.split_once("```").expect("every block ends").0);
    blocks.flat_map(str::lines).filter_map(|line| line.strip_prefix("$ ")).collect()
}

/// Puts programs of these names in front of the PATH of what runs in the folder of a test.
fn put(rher: &Rher, folder: &str, programs: &[(&str, &str)]) {
    fs::create_dir_all(rher.path(folder)).unwrap();
    for (name, script) in programs {
        let path = rher.path(folder).join(name);
        fs::write(&path, script).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
}

/// Runs a line in a shell, in the folder `page` of the test; `None` if the shell is not there.
fn run_in(rher: &Rher, shell: &str, options: &[&str], programs: &str, line: &str) -> Option<Ran> {
    let path = format!("{}:{}", rher.path(programs).display(), std::env::var("PATH").unwrap());
    let mut command = Command::new(shell);
    command.args(options).args(["-c", line]).current_dir(rher.path("page")).stdin(Stdio::null());
    command.env("PATH", path).env("RHER", env!("CARGO_BIN_EXE_rher"));
    command.env("REPOSITORY", concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    command.output().ok().map(Ran::from)
}

#[test]
fn the_page_works_from_top_to_bottom_in_every_shell() {
    let rher = Rher::new();
    fs::create_dir(rher.path("page")).unwrap();
    put(&rher, "short", &[("rher", SHORT_RHER), ("cargo", SHORT_CARGO), ("pip", SHORT_PIP)]);
    put(&rher, "echo", &[("rher", ECHO), ("cargo", ECHO), ("pip", ECHO)]);
    assert!(commands().len() > 20, "{:?}", commands());
    for line in commands() {
        let expected = run_in(&rher, "bash", &[], "echo", line).unwrap();
        for (shell, options) in [("zsh", ["-f"]), ("fish", ["--no-config"])] {
            // Where a shell is missing there is nothing to compare.
            let Some(ran) = run_in(&rher, shell, &options, "echo", line) else { continue };
            assert_eq!(ran.to_string(), expected.to_string(), "`{line}` in {shell}");
        }
        let ran = run_in(&rher, "bash", &[], "short", line).unwrap();
        assert_eq!(ran.status, Some(0), "`{line}`:\n{ran}");
    }
}
