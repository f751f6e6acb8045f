//! The program, run with the library in a room of its own.

use crate::preload::{Call, Injection, Noted, read_log};
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Whatever takes longer hangs.
const PATIENCE: Duration = Duration::from_mins(1);

/// A folder for one trial; the program runs in `work`.
pub(crate) struct Room(TempDir);

impl Room {
    pub(crate) fn new() -> Self {
        let room = Self(TempDir::new().unwrap());
        fs::create_dir(room.work()).unwrap();
        room
    }

    /// A room with the same files.
    pub(crate) fn copy(&self) -> Self {
        let room = Self::new();
        copy(&self.path("tiny.toml"), &room.path("tiny.toml"));
        copy(&self.work(), &room.work());
        room
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().canonicalize().unwrap().join(name)
    }

    pub(crate) fn work(&self) -> PathBuf {
        self.path("work")
    }
}

fn copy(from: &Path, to: &Path) {
    if !from.is_dir() {
        fs::copy(from, to).unwrap();
        return;
    }
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        copy(&entry.path(), &to.join(entry.file_name()));
    }
}

/// Why a program has no exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoStatus {
    Killed,
    /// Another signal than the one that kills: the program has crashed.
    Crashed(i32),
    /// It was still running after a minute.
    Hung,
}

/// How the program ended, what it said, and which calls it made.
pub(crate) struct Ended {
    pub(crate) status: Result<i32, NoStatus>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
    pub(crate) log: Vec<Noted>,
    pub(crate) took: Duration,
}

impl Noted {
    /// Whether a checkpoint got its name.
    pub(crate) fn is_save(&self) -> bool {
        self.call == Call::Rename
            && self.has_succeeded
            && self.path.ends_with("/checkpoint/current.ckpt")
    }
}

/// What is done to the program while it runs.
#[derive(Clone, Copy)]
enum Disturb<'a> {
    Not,
    Inject(&'a Injection),
    KillAfter(Duration),
}

/// The program, and the library that is preloaded into it.
pub(crate) struct Program {
    pub(crate) library: PathBuf,
}

impl Program {
    /// Undisturbed and unwatched.
    pub(crate) fn run(&self, room: &Room, arguments: &str) -> Ended {
        self.run_watched(room, arguments, "no such folder", None)
    }

    /// Watches what is below `watched`, and injects a fault there.
    pub(crate) fn run_watched(
        &self,
        room: &Room,
        arguments: &str,
        watched: &str,
        injection: Option<&Injection>,
    ) -> Ended {
        let disturb = injection.map_or(Disturb::Not, Disturb::Inject);
        self.start(room, arguments, watched, disturb)
    }

    /// Kills the program after a while.
    pub(crate) fn run_killed(
        &self,
        room: &Room,
        arguments: &str,
        watched: &str,
        after: Duration,
    ) -> Ended {
        self.start(room, arguments, watched, Disturb::KillAfter(after))
    }

    fn start(&self, room: &Room, arguments: &str, watched: &str, disturb: Disturb) -> Ended {
        let (log, stderr) = (room.path("log"), room.path("stderr"));
        let _ = fs::remove_file(&log);
        let mut command = Command::new(env!("CARGO_BIN_EXE_rher"));
        command
            .current_dir(room.work())
            .args(arguments.split_whitespace())
            .env("LD_PRELOAD", &self.library)
            .env("FAULTS_FOLDER", room.work().join(watched).to_string_lossy().trim_end_matches('/'))
            .env("FAULTS_LOG", &log)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(File::create(&stderr).unwrap());
        if let Disturb::Inject(injection) = disturb {
            command.envs(injection.environment());
        }
        let started = Instant::now();
        let mut child = command.spawn().unwrap();
        let (stdout, is_hung) = attend(&mut child, disturb);
        let status = child.wait().unwrap();
        let signal = std::os::unix::process::ExitStatusExt::signal(&status);
        let status = match (status.code(), signal) {
            _ if is_hung => Err(NoStatus::Hung),
            (Some(code), _) => Ok(code),
            (None, Some(9)) => Err(NoStatus::Killed),
            (None, signal) => Err(NoStatus::Crashed(signal.unwrap_or(0))),
        };
        let took = started.elapsed();
        let stderr = fs::read(&stderr).unwrap();
        let stderr = String::from_utf8_lossy(&stderr).into_owned();
        Ended { status, stdout, stderr, log: read_log(&log), took }
    }
}

/// Waits until the program and all that it started have ended: they all hold its output. What it
/// printed, and whether it had to be killed because it hung.
fn attend(child: &mut Child, disturb: Disturb) -> (String, bool) {
    let mut stdout = child.stdout.take().unwrap();
    let (sender, receiver) = mpsc::channel();
    let reader = thread::spawn(move || {
        let mut bytes = Vec::new();
        let read = stdout.read_to_end(&mut bytes);
        let _ = sender.send(());
        read.map(|_| String::from_utf8_lossy(&bytes).into_owned()).unwrap()
    });
    if let Disturb::KillAfter(delay) = disturb
        && receiver.recv_timeout(delay) == Err(mpsc::RecvTimeoutError::Timeout)
    {
        child.kill().unwrap();
    }
    let is_hung = receiver.recv_timeout(PATIENCE) == Err(mpsc::RecvTimeoutError::Timeout);
    if is_hung {
        child.kill().unwrap();
    }
    (reader.join().unwrap(), is_hung)
}
