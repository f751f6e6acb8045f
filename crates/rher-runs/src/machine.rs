//! What a run is made with: the program and the machine.

use rher_core::files::{self, FileError, is_absent};
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;
use std::path::Path;
use std::{env, fs, thread};

const MACHINE_FILE: &str = "machine.toml";

/// Largest file in bytes; that of a machine has about 100.
const LARGEST: u64 = 1 << 16;

/// The program and the machine that made a run; results depend on neither, times do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Name and version, and the commit if the builder said it in `RHER_COMMIT`.
    pub program: String,
    /// Operating system and instruction set.
    pub system: String,
    /// Model of the processor, if the system tells.
    pub processor: String,
    /// Cores that the program may use.
    pub cores: usize,
}

impl Machine {
    /// This one.
    pub fn here() -> Self {
        let processors = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let mut models =
            processors.lines().filter_map(|line| line.strip_prefix("model name")?.split_once(": "));
        Self {
            program: program(),
            system: format!("{} {}", env::consts::OS, env::consts::ARCH),
            processor: models.next().map_or("unknown", |(_, model)| model).to_owned(),
            cores: thread::available_parallelism().map_or(1, NonZeroUsize::get),
        }
    }

    /// The one that made the run in a folder, if that was kept.
    ///
    /// # Errors
    ///
    /// What is wrong with the file that says it.
    pub fn of_run(folder: &Path) -> Result<Option<Self>, String> {
        match files::read_at_most(&folder.join(MACHINE_FILE), LARGEST) {
            Ok(bytes) => toml::from_slice(&bytes).map(Some).map_err(|error| error.to_string()),
            Err(error) if is_absent(&error.source) => Ok(None),
            Err(error) => Err(error.source.to_string()),
        }
    }

    /// Keeps it with a run.
    pub(crate) fn write(&self, folder: &Path) -> Result<(), FileError> {
        let path = folder.join(MACHINE_FILE);
        let text = toml::to_string(self).expect("text and a number can be written as TOML");
        files::replace(&path, text.as_bytes())
    }
}

fn program() -> String {
    let commit = option_env!("RHER_COMMIT").map(|commit| format!(", commit {commit}"));
    concat!("rher ", env!("CARGO_PKG_VERSION")).to_owned() + &commit.unwrap_or_default()
}
