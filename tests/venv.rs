//! The virtual environment that all tests with Python share: below `target/`, and made anew when
//! its requirements change, so only the first run installs anything.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const REQUIREMENTS: &str = include_str!("requirements.txt");
const LEROBOT: &str = include_str!("requirements-lerobot.txt");

/// Its interpreter, or why there is none.
pub(crate) fn python() -> Result<&'static Path, &'static str> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    PYTHON.get_or_init(install).as_deref().map_err(String::as_str)
}

fn install() -> Result<PathBuf, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    let python = folder.join("bin/python");
    let installed = folder.join("installed.txt");
    let wanted = [REQUIREMENTS, LEROBOT].concat();
    if std::fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    succeed(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    for (text, options) in [(REQUIREMENTS, &[] as &[&str]), (LEROBOT, &["--no-deps"])] {
        let requirements = folder.join("requirements.txt");
        std::fs::write(&requirements, text).map_err(|error| error.to_string())?;
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        succeed(pip.args(options).arg("-r").arg(requirements))?;
    }
    std::fs::write(installed, wanted).map_err(|error| error.to_string())?;
    Ok(python)
}

fn succeed(command: &mut Command) -> Result<(), String> {
    match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(format!("{command:?}: {}", String::from_utf8_lossy(&output.stderr))),
        Err(error) => Err(format!("{command:?}: {error}")),
    }
}
