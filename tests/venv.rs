//! Virtual environments for tests with Python: below `target/`, and made anew when their
//! requirements change, so only the first run installs anything.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// A virtual environment.
pub(crate) struct Venv {
    /// The folder below `target/tmp`.
    pub(crate) folder: &'static str,
    /// The program that makes it.
    pub(crate) interpreter: &'static str,
    /// Packages, as pip reads them from a file.
    pub(crate) requirements: &'static str,
    /// Packages that are installed without what they ask for.
    pub(crate) no_deps: &'static str,
}

/// The one that all tests with Python share.
pub(crate) const SHARED: Venv = Venv {
    folder: "python",
    interpreter: "python3",
    requirements: include_str!("requirements.txt"),
    no_deps: include_str!("requirements-no-deps.txt"),
};

/// For packages that need a newer Python.
const NEWER: Venv = Venv {
    folder: "python-3.12",
    interpreter: "python3.12",
    requirements: include_str!("requirements-3.12.txt"),
    no_deps: include_str!("requirements-3.12-no-deps.txt"),
};

/// The interpreter of Python 3.12, or why there is none.
pub(crate) fn python_3_12() -> Result<PathBuf, String> {
    let version = "import ensurepip, venv, sys; sys.exit(sys.version_info[:2] != (3, 12))";
    let started = Command::new(NEWER.interpreter).args(["-c", version]).output();
    if !started.is_ok_and(|output| output.status.success()) {
        return Err("there is no `python3.12` with `venv`, which LeRobot 0.6.1 needs".to_owned());
    }
    NEWER.python()
}

/// The interpreter of the shared one, or why there is none.
pub(crate) fn python() -> Result<&'static Path, &'static str> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    PYTHON.get_or_init(|| SHARED.python()).as_deref().map_err(String::as_str)
}

impl Venv {
    /// Its interpreter, or why there is none.
    pub(crate) fn python(&self) -> Result<PathBuf, String> {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(self.folder);
        let python = folder.join("bin/python");
        let installed = folder.join("installed.txt");
        let wanted = [self.requirements, self.no_deps].concat();
        if std::fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
            return Ok(python);
        }
        succeed(Command::new(self.interpreter).args(["-m", "venv", "--clear"]).arg(&folder))?;
        for (text, options) in [(self.requirements, &[] as &[&str]), (self.no_deps, &["--no-deps"])]
        {
            let requirements = folder.join("requirements.txt");
            std::fs::write(&requirements, text).map_err(|error| error.to_string())?;
            let mut pip = Command::new(&python);
            pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
            succeed(pip.args(options).arg("-r").arg(requirements))?;
        }
        std::fs::write(installed, wanted).map_err(|error| error.to_string())?;
        Ok(python)
    }
}

fn succeed(command: &mut Command) -> Result<(), String> {
    match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr))),
        Err(error) => Err(format!("{command:?}: {error}")),
    }
}
