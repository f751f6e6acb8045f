//! The Python package, tested by pytest.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../venv.rs"]
mod venv;

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use venv::Venv;

/// What the package depends on.
const BARE: &str = "gymnasium==1.4.0\nnumpy==2.4.0\n";

#[test]
#[cfg_attr(not(python3), ignore = "there is no `python3` from 3.10 on with `venv`")]
fn pytest_passes() {
    let python = venv::python().unwrap();
    let pip = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
    run(Command::new(python).args(pip).arg(wheel()));
    let report = run(Command::new(python)
        .args(["-m", "pytest", "--quiet", "-rs", "-p", "no:cacheprovider", "--durations=5"])
        // On a shared machine PyTorch's threads wait for each other most of the time.
        .env("OMP_NUM_THREADS", "1")
        .env("RHER", env!("CARGO_BIN_EXE_rher"))
        .current_dir(package()));
    assert!(report.contains(" passed"), "pytest ran nothing:\n{report}");
    for skipped in report.lines().filter(|line| line.starts_with("SKIPPED")) {
        // Past the harness, which keeps what passing tests print.
        let _ = writeln!(io::stderr(), "{skipped}");
    }
}

/// What a user has who installs the wheel and nothing else, without Rust.
#[test]
#[cfg_attr(not(python3), ignore = "there is no `python3` from 3.10 on with `venv`")]
fn the_wheel_is_all_that_a_user_needs() {
    let bare = Venv { folder: "bare", requirements: BARE, no_deps: "", ..venv::SHARED };
    let python = bare.python().unwrap();
    let pip = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
    run(Command::new(&python).args(pip).arg(wheel()));
    run(Command::new(&python).args(["-m", "pip", "check"]));
    let folder = tempfile::tempdir().unwrap();
    // Neither `cargo` nor anything else of this machine.
    let alone = |program: &Path| {
        let mut command = Command::new(program);
        command.env_clear().env("PATH", python.parent().unwrap()).current_dir(folder.path());
        command
    };
    run(alone(&python.with_file_name("rher")).args(["train", "reach", "--env-steps", "2000"]));
    assert!(folder.path().join("runs/reach-rher-fast-1/policy.safetensors").is_file());
    let steps = package().join("tests/bare/first_steps.py");
    run(alone(&python).arg(steps).arg(package().join("README.md")));
}

/// LeRobot needs a newer Python than the shared one may be, and its plugin is a package of its own.
#[test]
#[cfg_attr(not(python3), ignore = "there is no `python3` from 3.10 on with `venv`")]
fn policies_and_robots_are_those_of_lerobot() {
    let python = match venv::python_3_12() {
        Ok(python) => python,
        Err(why) => {
            let _ = writeln!(io::stderr(), "ignored: {why}");
            return;
        }
    };
    let pip = ["-m", "pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
    run(Command::new(&python).args(pip).arg(wheel()));
    let mut plugin = Command::new(&python);
    plugin.args(pip).arg("--no-build-isolation").arg(package().join("lerobot_policy_rher"));
    run(&mut plugin);
    let report = run(Command::new(&python)
        .args(["-m", "pytest", "--quiet", "-rs", "-p", "no:cacheprovider"])
        .args(["tests/test_lerobot.py", "tests/test_control_loop.py"])
        .env("OMP_NUM_THREADS", "1")
        .current_dir(package()));
    assert!(report.contains(" passed") && !report.contains("skipped"), "{report}");
}

/// The package's folder.
fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../rher-py").canonicalize().unwrap()
}

/// The wheel, built once, with the tools that are in the shared environment.
fn wheel() -> &'static Path {
    static WHEEL: OnceLock<PathBuf> = OnceLock::new();
    WHEEL.get_or_init(|| {
        let python = venv::python().unwrap();
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wheel");
        let _ = std::fs::remove_dir_all(&folder);
        let mut maturin = Command::new(python.with_file_name("maturin"));
        maturin.args(["build", "--quiet", "--release", "--out"]).arg(&folder);
        run(maturin
            .arg("--interpreter")
            .arg(python)
            .env("PATH", path(python))
            .current_dir(package()));
        let mut wheels = std::fs::read_dir(&folder).unwrap();
        let wheel = wheels.next().expect("maturin has written a wheel").unwrap().path();
        assert!(wheels.next().is_none(), "one wheel is for every Python");
        wheel
    })
}

/// Where programs are looked for: beside `python` first, where maturin is.
fn path(python: &Path) -> OsString {
    let beside = python.parent().unwrap().to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(beside).chain(std::env::split_paths(&path));
    std::env::join_paths(folders).unwrap()
}

/// Runs `command`, which must succeed, and returns what it printed.
fn run(command: &mut Command) -> String {
    // Cargo tells the test about itself, and what the test builds should not hear of it.
    let ours = std::env::vars_os().filter(|(name, _)| {
        let name = name.to_string_lossy();
        name.starts_with("CARGO_") && !matches!(&*name, "CARGO_HOME" | "CARGO_TARGET_DIR")
    });
    for (name, _) in ours {
        command.env_remove(name);
    }
    let output = command.output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    assert!(output.status.success(), "{command:?}: {}\n{said}", output.status);
    said
}
