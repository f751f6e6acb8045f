//! A folder of its own for every test, and the program run in it.

use serde_json::Value;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Options that make a run take a second or less.
pub(crate) const TINY: &str = "--until 0 \
    --set agent.hidden=[16,16] --set replay.batch_size=16 --set replay.updates_per_episode=2 \
    --set evaluation.every_episodes=5 --set evaluation.episodes=5 \
    --set evaluation.subtask_episodes=2";

/// The program in an empty folder; paths in arguments are relative to it.
pub(crate) struct Rher {
    folder: TempDir,
}

impl Rher {
    pub(crate) fn new() -> Self {
        Self { folder: TempDir::new().unwrap() }
    }

    pub(crate) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// The program with these arguments, separated by blanks.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rher"));
        command
            .current_dir(self.folder.path())
            .env("COLUMNS", "100")
            .args(arguments.split_whitespace())
            .stdin(Stdio::null());
        command
    }

    /// Runs it to its end.
    pub(crate) fn run(&self, arguments: &str) -> Ran {
        self.command(arguments).output().unwrap().into()
    }

    /// Runs it, and expects that all goes well.
    pub(crate) fn ok(&self, arguments: &str) -> String {
        let ran = self.run(arguments);
        assert_eq!(ran.status, Some(0), "`rher {arguments}`:\n{ran}");
        ran.stdout
    }

    /// Starts it and lets it run.
    pub(crate) fn spawn(&self, arguments: &str) -> Running {
        // Whoever started the tests in the background of a script ignores Ctrl-C.
        let mut command = Command::new("env");
        command
            .current_dir(self.folder.path())
            .args(["--default-signal=INT,HUP,TERM", env!("CARGO_BIN_EXE_rher")])
            .args(arguments.split_whitespace())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        Running(Some(command.spawn().unwrap()))
    }

    /// Starts it with SIGHUP ignored, as `nohup` does.
    pub(crate) fn spawn_ignoring_hangups(&self, arguments: &str) -> Running {
        let mut command = Command::new("sh");
        command
            .current_dir(self.folder.path())
            .args(["-c", "trap '' HUP; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_rher")])
            .args(arguments.split_whitespace())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        Running(Some(command.spawn().unwrap()))
    }

    /// Waits until nobody writes in a run any more; how long it took.
    pub(crate) fn wait_until_free(&self, run: &str) -> Duration {
        let started = Instant::now();
        let lock = std::fs::File::open(self.path(run).join(".lock")).unwrap();
        while lock.try_lock().is_err() {
            assert!(started.elapsed() < Duration::from_mins(1), "still in use after a minute");
            std::thread::sleep(Duration::from_millis(5));
        }
        started.elapsed()
    }

    /// The metrics of a run but for its wall clock.
    pub(crate) fn metrics(&self, run: &str) -> Vec<Value> {
        let text = std::fs::read_to_string(self.path(run).join("metrics.jsonl")).unwrap();
        let line = |line: &str| {
            let mut metrics: Value = serde_json::from_str(line).unwrap();
            let fields = metrics.as_object_mut().unwrap();
            assert!(fields.remove("wall_s").is_some() && fields.remove("time").is_some());
            // The checksum is over the wall clock, too.
            assert!(fields.remove("crc32").is_some() == fields.remove("run").is_some());
            metrics
        };
        text.lines().map(line).collect()
    }

    /// Waits until a run has written its first metrics.
    pub(crate) fn wait_for_metrics(&self, run: &str) {
        let started = Instant::now();
        let path = self.path(run).join("metrics.jsonl");
        while std::fs::metadata(&path).map_or(0, |file| file.len()) == 0 {
            assert!(started.elapsed() < Duration::from_mins(1), "no metrics after a minute");
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// A shell command in the folder of a test, with the program as `$RHER`.
pub(crate) fn shell(rher: &Rher, script: &str) -> Ran {
    let mut command = Command::new("sh");
    command.args(["-c", script]).current_dir(rher.path(""));
    command.env("RHER", env!("CARGO_BIN_EXE_rher")).output().unwrap().into()
}

/// How the program ended, and what it said.
pub(crate) struct Ran {
    pub(crate) status: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Ran {
    fn from(Output { status, stdout, stderr }: Output) -> Self {
        Self {
            status: status.code(),
            stdout: String::from_utf8(stdout).unwrap(),
            stderr: String::from_utf8(stderr).unwrap(),
        }
    }
}

impl fmt::Display for Ran {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { status, stdout, stderr } = self;
        match status {
            Some(status) => writeln!(f, "exit {status}")?,
            None => writeln!(f, "killed")?,
        }
        write!(f, "{stdout}{stderr}")
    }
}

/// A program that is killed when a test forgets it.
pub(crate) struct Running(Option<Child>);

impl Running {
    /// As Ctrl-C does.
    pub(crate) fn interrupt(&self) {
        self.send("INT");
    }

    /// Sends a signal, such as `TERM`.
    pub(crate) fn send(&self, signal: &str) {
        let id = self.0.as_ref().unwrap().id().to_string();
        let sent = Command::new("kill").args([&format!("-{signal}"), &id]).status().unwrap();
        assert!(sent.success());
    }

    /// As `kill -9` does.
    pub(crate) fn kill(mut self) {
        let mut child = self.0.take().unwrap();
        child.kill().unwrap();
        child.wait().unwrap();
    }

    pub(crate) fn end(mut self) -> Ran {
        self.0.take().unwrap().wait_with_output().unwrap().into()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
