//! What the program finds around itself: folders to write to, and a Python with the package.

use serde::{Deserialize, Serialize};
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A folder that commands write to.
#[derive(Serialize)]
pub(crate) struct Folder {
    path: PathBuf,
    /// Why nothing can be written there.
    problem: Option<String>,
}

impl Folder {
    /// Tries it, by a file that is gone at once.
    fn tried(path: PathBuf) -> Self {
        let problem = tempfile::tempfile_in(&path).err().map(|error| error.to_string());
        Self { path, problem }
    }

    /// Where runs are made unless another folder is named.
    pub(crate) fn working() -> Self {
        Self::tried(env::current_dir().unwrap_or_else(|_| ".".into()))
    }

    /// Where what ships with the program is unpacked.
    pub(crate) fn temporary() -> Self {
        Self::tried(env::temp_dir())
    }

    /// What is odd about it.
    pub(crate) fn odd(&self) -> Option<String> {
        let path = self.path.display();
        self.problem.as_ref().map(|problem| format!("`{path}` cannot be written to: {problem}"))
    }

    /// Its path, and whether it can be written to.
    pub(crate) fn describe(&self) -> String {
        let verdict = if self.problem.is_none() { "writable" } else { "NOT WRITABLE" };
        format!("{} ({verdict})", self.path.display())
    }
}

/// An interpreter of Python, and the versions of packages that it has.
#[derive(Serialize, Deserialize)]
pub(crate) struct Python {
    interpreter: PathBuf,
    version: String,
    rher: Option<String>,
    numpy: Option<String>,
    gymnasium: Option<String>,
}

/// Prints a [`Python`] as JSON, without importing what it asks about.
const ASK: &str = "
import importlib.metadata, json, platform, sys
found = {'interpreter': sys.executable, 'version': platform.python_version()}
for name in ('rher', 'numpy', 'gymnasium'):
    try:
        found[name] = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        found[name] = None
print(json.dumps(found))
";

impl Python {
    /// This interpreter; `None` if it does not start.
    pub(crate) fn of(interpreter: &Path) -> Option<Self> {
        let mut python = Command::new(interpreter);
        let asked = python.args(["-c", ASK]).stdin(Stdio::null()).output().ok()?;
        serde_json::from_slice(&asked.stdout).ok()
    }

    /// What is odd about it, for a program of this version.
    pub(crate) fn odd(&self, program: &str) -> Option<String> {
        let interpreter = self.interpreter.display();
        match self {
            Self { rher: Some(rher), .. } if rher != program => Some(format!(
                "`{interpreter}` has version {rher} of the package rher, and this program is {program}"
            )),
            Self { rher: Some(_), numpy: None, .. } => {
                Some(format!("`{interpreter}` has the package rher, but not NumPy, which it needs"))
            }
            Self { rher: Some(_), gymnasium: None, .. } => Some(format!(
                "`{interpreter}` has the package rher, but not Gymnasium, which it needs"
            )),
            _ => None,
        }
    }

    /// Its version, and what it has.
    pub(crate) fn describe(&self) -> String {
        let Self { interpreter, version, rher, numpy, gymnasium } = self;
        let packages = [("rher", rher), ("NumPy", numpy), ("Gymnasium", gymnasium)]
            .map(|(name, version)| format!("{name} {}", version.as_deref().unwrap_or("absent")));
        format!("{version} in {}: {}", interpreter.display(), packages.join(", "))
    }
}
