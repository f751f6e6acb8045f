//! The commands of the documents work as they are written, in the order of each page.
//!
//! Every page is run in a folder of its own. Programs in front of the PATH make short what takes long,
//! and leave the command as it is: `rher` trains for 100 steps, and measures the speed of one task or
//! size; `cargo` runs the programs that it has built for the tests; and what installs something, or
//! needs a cluster, looks only whether what is named is there.
//! A command whose output a page shows is run as it stands, and the output is compared.

use crate::python;
use crate::site::{chapters, root};
use crate::support::{Ran, Rher};
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// Takes the end that a command has for its training from it, and gives it another one.
const SHORT_RHER: &str = r#"#!/bin/bash
case "$1 $2" in
    "train --resume") end=200 ;;
    "sweep --"*) exec "$RHER" "$@" ;;
    "train "* | "sweep "*)
        end=100
        set -- "$@" --set replay.updates_per_episode=1 --set evaluation.episodes=5 \
            --set evaluation.subtask_episodes=2
        ;;
    "reproduce "*) end=100 ;;
    "bench env") exec "$RHER" "$@" --task push ;;
    "bench update") exec "$RHER" "$@" --batch 128 --inputs 31 --threads 1 ;;
    *) exec "$RHER" "$@" ;;
esac
arguments=()
while [ $# -gt 0 ]; do
    case "$1" in
        --env-steps) shift ;;
        *) arguments+=("$1") ;;
    esac
    shift
done
exec "$RHER" "${arguments[@]}" --env-steps "$end"
"#;

const SHORT_CARGO: &str = r#"#!/bin/sh
case "$*" in
    "run --release --bin rher -- "*) shift 5; exec rher "$@" ;;
    "run --release -- "*) shift 3; RHER="$EXAMPLES/corner" exec rher "$@" ;;
    "run --release -p "*" --example "*) test -e "$REPOSITORY/crates/$4/examples/$6.rs" ;;
    "run --release --features live --bin rher -- "*)
        grep -q '^live = ' "$REPOSITORY/crates/rher-cli/Cargo.toml" ;;
    "install --path "*) test -e "$REPOSITORY/$3/Cargo.toml" ;;
    "test --release -p "*) test -e "$REPOSITORY/crates/$4/Cargo.toml" ;;
    "build --release" | "test --release") ;;
    *) echo "the test of the pages does not know 'cargo $*'" >&2; exit 1 ;;
esac
"#;

/// A path that is named is from the root of the repository, or from the folder of the page.
/// A wheel has the version of the workspace.
const SHORT_PIP: &str = r#"#!/bin/sh
case "$2" in rher-*-cp310-abi3-*.whl)
    exec grep -q "^version = \"$(echo "$2" | cut -d - -f 2)\"" "$REPOSITORY/Cargo.toml" ;;
esac
folder="${2%%[*}"
test "$1" = install && { test -e "$REPOSITORY/$folder/pyproject.toml" || test -e "$PAGE/$folder/pyproject.toml"; }
"#;

const SHORT_PYTHON: &str = r#"#!/bin/sh
test "$1" = -m || exit 1
for folder in python lerobot_policy_rher/src; do
    module="$REPOSITORY/crates/rher-py/$folder/$(echo "$2" | tr . /)"
    if test -e "$module.py" || test -e "$module/__main__.py"; then exit 0; fi
done
exit 1
"#;

const SHORT_SBATCH: &str = "#!/bin/sh\ntest -e \"$2\"\n";

/// `crates/rher-py/tests` runs it.
const SHORT_LEROBOT: &str = "#!/bin/sh\ncase \"$1\" in --policy.path=*) ;; *) exit 1 ;; esac\n";

/// Without Python there is no Minari to try.
const SHORT_MINARI: &str = "#!/bin/sh\ntest -z \"$MINARI\" || exec \"$MINARI\" \"$@\"\n";

/// Prints its arguments, one on a line.
const ECHO: &str = "#!/bin/sh\nprintf '[%s]\\n' \"$@\"\n";

/// What a page takes for granted.
const RUNS: [(&str, &[&str]); 2] = [
    ("docs/recording.md", &["runs/push-rher-fast-1", "runs/push-rher-fast-2"]),
    ("docs/onnx.md", &["runs/push-rher-fast-1"]),
];

/// A command of a page, and what the page shows of its output.
#[derive(Debug)]
struct Step {
    line: String,
    output: String,
}

/// The commands of a page, in its order.
fn steps(page: &Path) -> Vec<Step> {
    let text = fs::read_to_string(root().join(page)).unwrap();
    let blocks = text.split("```console\n").skip(1);
    let blocks = blocks.map(|rest| rest.split_once("```").expect("every block ends").0);
    let mut steps: Vec<Step> = vec![];
    for line in blocks.flat_map(str::lines) {
        if let Some(command) = line.strip_prefix("$ ") {
            steps.push(Step { line: command.to_owned(), output: String::new() });
            continue;
        }
        let step = steps.last_mut().expect("a block begins with a command");
        if step.line.ends_with('\\') {
            step.line.extend(["\n", line]);
        } else {
            step.output.extend([line, "\n"]);
        }
    }
    steps
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

/// The folder of a test in which a page is run.
fn folder_of(page: &Path) -> Rher {
    let rher = Rher::new();
    fs::create_dir(rher.path("page")).unwrap();
    // Some pages draw the runs that are published.
    std::os::unix::fs::symlink(root().join("docs"), rher.path("page/docs")).unwrap();
    put(&rher, "echo", &["rher", "cargo", "pip"].map(|name| (name, ECHO)));
    put(
        &rher,
        "short",
        &[
            ("rher", SHORT_RHER),
            ("cargo", SHORT_CARGO),
            ("pip", SHORT_PIP),
            ("python", SHORT_PYTHON),
            ("sbatch", SHORT_SBATCH),
            ("lerobot-eval", SHORT_LEROBOT),
            ("minari", SHORT_MINARI),
        ],
    );
    put(&rher, "whole", &[("rher", "#!/bin/sh\nexec \"$RHER\" \"$@\"\n")]);
    let runs = RUNS.iter().find(|(name, _)| Path::new(name) == page).map_or(&[] as _, |it| it.1);
    for run in runs {
        let line = format!("rher train push --out {run}");
        assert_eq!(run_in(&rher, page, "bash", &[], "short", &line).unwrap().status, Some(0));
    }
    rher
}

/// Runs a line in a shell, in the folder `page` of the test; `None` if the shell is not there.
fn run_in(
    rher: &Rher,
    page: &Path,
    shell: &str,
    options: &[&str],
    programs: &str,
    line: &str,
) -> Option<Ran> {
    let path = format!("{}:{}", rher.path(programs).display(), std::env::var("PATH").unwrap());
    let program = Path::new(env!("CARGO_BIN_EXE_rher"));
    let mut command = Command::new(shell);
    command.args(options).args(["-c", line]).current_dir(rher.path("page")).stdin(Stdio::null());
    command.env("PATH", path).env("COLUMNS", "100").env("RHER", program);
    command.env("EXAMPLES", program.with_file_name("examples")).env("REPOSITORY", root());
    command.env("PAGE", root().join(page.parent().unwrap()));
    if let Some(python) = python::python() {
        command.env("MINARI", python.with_file_name("minari"));
    }
    command.output().ok().map(Ran::from)
}

/// Runs a page from its top to its bottom; these shells must read every line as bash does.
fn run(page: &Path, shells: &[(&str, &str)]) {
    let rher = folder_of(page);
    for Step { line, output } in steps(page) {
        for &(shell, option) in shells {
            // Where a shell is missing there is nothing to compare.
            let Some(ran) = run_in(&rher, page, shell, &[option], "echo", &line) else { continue };
            let expected = run_in(&rher, page, "bash", &[], "echo", &line).unwrap();
            assert_eq!(ran.to_string(), expected.to_string(), "`{line}` in {shell}");
        }
        if output.is_empty() {
            let ran = run_in(&rher, page, "bash", &[], "short", &line).unwrap();
            assert_eq!(ran.status, Some(0), "{}: `{line}`:\n{ran}", page.display());
        } else {
            let whole = format!("exec 2>&1\n{line}");
            let ran = run_in(&rher, page, "bash", &[], "whole", &whole).unwrap();
            assert_eq!(ran.status, Some(0), "{}: `{line}`:\n{ran}", page.display());
            snapbox::assert_data_eq!(ran.stdout, output);
        }
    }
}

#[test]
fn the_first_page_works_from_top_to_bottom_in_every_shell() {
    let page = Path::new("README.md");
    assert!(steps(page).len() > 20, "{:?}", steps(page));
    run(page, &[("zsh", "-f"), ("fish", "--no-config")]);
}

#[test]
fn every_page_works_from_top_to_bottom() {
    let mut commands = 0;
    for page in chapters() {
        // Notes say what was run at their time, some of it for hours and by earlier programs.
        let is_note = page.starts_with("docs/archive");
        if page != Path::new("README.md") && !is_note {
            commands += steps(&page).len();
            run(&page, &[]);
        }
    }
    assert!(commands > 50, "only {commands} commands were run");
}
