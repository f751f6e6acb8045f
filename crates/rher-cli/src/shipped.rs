//! The runs that ship with the program, as folders.

use crate::numbers::{percent, thousands};
use crate::printer::Printer;
use crate::values::task_named;
use anyhow::Context as _;
use rher_core::files::FileError;
use rher_core::train::checkpoint::POLICY_FILE;
use rher_policies::{Card, Shipped};
use rher_runs::{CONFIG_FILE, METRICS_FILE};
use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use tempfile::TempDir;

/// Where they are unpacked, until the program ends.
static UNPACKED: Mutex<Option<TempDir>> = Mutex::new(None);

/// `path`, or the folder of the run that ships with the program where `path` is the name of a task
/// and no file or folder.
pub(crate) fn folder(path: &Path, printer: Printer) -> anyhow::Result<Cow<'_, Path>> {
    let task = path.to_str().filter(|_| !path.exists()).and_then(task_named);
    let Some(shipped) = task.and_then(|task| rher_policies::of(task.name())) else {
        return Ok(path.into());
    };
    let Card { success, episodes, command, .. } = shipped.card();
    printer.note(format_args!(
        "note: there is no `{}` here; this is the policy that ships with the program, which \
         succeeds in {} of {} unseen episodes and was made by `{command}`",
        path.display(),
        percent(success.into()),
        thousands(episodes as u64),
    ));
    Ok(unpack(shipped)?.into())
}

/// Writes its files into a folder that is named like the task.
fn unpack(shipped: &Shipped) -> anyhow::Result<PathBuf> {
    let mut unpacked = UNPACKED.lock().expect("no thread panics while it unpacks");
    let place = match &mut *unpacked {
        Some(place) => place,
        empty => empty.insert(
            tempfile::Builder::new()
                .prefix("rher-")
                .tempdir()
                .map_err(FileError::write(&std::env::temp_dir()))
                .context(
                    "what ships with the program is unpacked into a temporary folder; the variable \
                     TMPDIR says where",
                )?,
        ),
    };
    let folder = place.path().join(shipped.task);
    fs::create_dir_all(&folder).map_err(FileError::write(&folder))?;
    for (name, bytes) in [
        (CONFIG_FILE, shipped.config),
        (METRICS_FILE, shipped.metrics),
        (POLICY_FILE, shipped.policy),
    ] {
        let path = folder.join(name);
        fs::write(&path, bytes).map_err(FileError::write(&path))?;
    }
    Ok(folder)
}

/// What a file or a folder is called in a text: those that were unpacked by what they were asked for
/// by.
pub(crate) fn name(path: &Path) -> String {
    let unpacked = UNPACKED.lock().expect("no thread panics while it unpacks");
    let below = unpacked.as_ref().and_then(|place| path.strip_prefix(place.path()).ok());
    below.unwrap_or(path).display().to_string()
}

/// Removes what was unpacked.
pub(crate) fn remove() {
    // What cannot be removed stays in the folder for temporary files.
    drop(UNPACKED.lock().map(|mut unpacked| unpacked.take()));
}
