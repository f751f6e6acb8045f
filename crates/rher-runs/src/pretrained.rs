//! The run in a folder as the start of another one.

use rher_core::Names;
use rher_core::policy::PolicyInfo;
use rher_core::train::{Pretrained, PretrainedError};
use rher_envs::{Options, Task};
use std::path::Path;

/// Reads the run in `folder`. If its task is one of ours, the numbers of its environment have names.
///
/// # Errors
///
/// Those of [`Pretrained::read`].
pub fn read_pretrained(folder: &Path) -> Result<Pretrained, PretrainedError> {
    Pretrained::read(folder, |info| names(info).unwrap_or_default())
}

/// None if this version of the program does not have the task, or not with these options.
fn names(PolicyInfo { task, variant, .. }: &PolicyInfo) -> Option<Names> {
    let task: Task = task.parse().ok()?;
    let options = match variant.as_str() {
        "" => Options::of(task.options()),
        variant => variant.parse().ok()?,
    };
    task.names(&options).ok()
}
