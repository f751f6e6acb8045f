//! Recordings as datasets for those who learn from demonstrations.

mod columns;
mod lerobot;
mod minari;

pub use lerobot::lerobot;
pub use minari::minari;

use crate::message::{Action, Begin, Frame, Message, Place, Timed};
use crate::{About, Recorded};
use rher_core::files::FileError;
use std::io;
use std::path::{Path, PathBuf};

/// An episode as demonstrations are kept: flat rows, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Demonstration {
    /// Seed that the environment was reset with.
    pub seed: u64,
    /// T.
    pub steps: usize,
    /// `[T + 1, observation]`.
    pub observations: Vec<f32>,
    /// `[T + 1, goal]`: where the objects are, or the gripper if the task is to reach.
    pub achieved: Vec<f32>,
    /// `[goal]`: where the same should be.
    pub desired: Vec<f32>,
    /// `[T, action]`, as the environment got them.
    pub actions: Vec<f32>,
    /// `[T]`.
    pub rewards: Vec<f32>,
    /// `[T + 1]`: whether the task is solved.
    pub successes: Vec<bool>,
}

/// A dataset cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Something is in its place already.
    #[error("`{}` exists already", path.display())]
    Exists {
        /// Where it should be.
        path: PathBuf,
    },
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// A table could not be put together.
    #[error("cannot write a table of `{}`", path.display())]
    Table {
        /// The dataset.
        path: PathBuf,
        /// What is wrong.
        source: parquet::errors::ParquetError,
    },
}

impl Demonstration {
    /// An episode that was just played and told.
    pub fn told(about: &About, messages: &[Timed]) -> Self {
        let mut begins = Vec::new();
        let (mut frames, mut actions) = (Vec::new(), Vec::new());
        for Timed { message, .. } in messages {
            match message {
                Message::Begin(begin) => begins.push(begin.clone()),
                Message::Frame(frame) => frames.push(frame.clone()),
                Message::Action(action) => actions.push(action.clone()),
                Message::Transforms(_) | Message::Scene(_) => {}
            }
        }
        Self::of(about, &begins[0], &frames, &actions)
    }

    /// An episode that was recorded.
    pub fn recorded(about: &About, recorded: &Recorded) -> Self {
        let Recorded { begin, frames, actions, .. } = recorded;
        Self::of(about, begin, frames, actions)
    }

    fn of(about: &About, begin: &Begin, frames: &[Frame], actions: &[Action]) -> Self {
        let flat = |places: &[Place]| places.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        // The last sub-task brings the gripper somewhere if there is an odd number of them.
        let reaches = !about.subtasks.is_multiple_of(2);
        let achieved = |frame: &Frame| -> Vec<f32> {
            if reaches { flat(&[frame.gripper]) } else { flat(&frame.objects) }
        };
        let desired = if reaches {
            flat(&begin.targets[about.subtasks / 2..][..1])
        } else {
            flat(&begin.targets)
        };
        Self {
            seed: begin.seed,
            steps: begin.steps,
            observations: frames.iter().flat_map(|frame| frame.observation.clone()).collect(),
            achieved: frames.iter().flat_map(achieved).collect(),
            desired,
            actions: actions
                .iter()
                .flat_map(|action| action.action.iter().map(|x| x.clamp(-1.0, 1.0)))
                .collect(),
            rewards: frames.iter().filter_map(|frame| frame.reward).collect(),
            successes: frames.iter().map(|frame| frame.success).collect(),
        }
    }

    /// Numbers in an observation, in a goal and in an action.
    fn widths(&self) -> [usize; 3] {
        let Self { steps, observations, desired, actions, .. } = self;
        [observations.len() / (steps + 1), desired.len(), actions.len() / steps]
    }
}

/// Fills a folder beside `path` and gives it that name once it is whole; what was begun is taken
/// away if it cannot be finished.
fn whole_folder(
    path: &Path,
    fill: impl FnOnce(&Path) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    if path.exists() {
        return Err(ExportError::Exists { path: path.to_owned() });
    }
    let part = path.with_added_extension("part");
    let failed = |source| ExportError::from(FileError::write(path)(source));
    // What a killed export left behind.
    match std::fs::remove_dir_all(&part) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(error)),
        _ => {}
    }
    std::fs::create_dir_all(&part).map_err(failed)?;
    fill(&part).and_then(|()| std::fs::rename(&part, path).map_err(failed)).inspect_err(|_| {
        let _ = std::fs::remove_dir_all(&part);
    })
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    let failed = |source| ExportError::from(FileError::write(path)(source));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    std::fs::write(path, bytes).map_err(failed)
}
