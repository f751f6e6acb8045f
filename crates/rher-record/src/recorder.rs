//! Recordings of training episodes, exploration included.

use crate::file::RecordingFile;
use crate::info::RecordingInfo;
use crate::player::{PlayError, Player};
use rher_core::explore::ActionLog;
use rher_core::files::FileError;
use rher_envs::Simulated;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};

/// Records every K-th training episode in the folder of its run.
pub struct Recorder<E, const N: usize> {
    every: NonZeroU64,
    folder: PathBuf,
    info: RecordingInfo,
    player: Player<E, N>,
    /// `None` until there is an episode.
    file: Option<RecordingFile>,
}

/// An episode is not recorded.
#[derive(Debug, thiserror::Error)]
pub enum RecorderError {
    /// The file cannot be written.
    #[error(transparent)]
    Write(FileError),
    /// The episode cannot be played again.
    #[error(transparent)]
    Play(PlayError),
}

impl<const N: usize, E: Simulated<N>> Recorder<E, N> {
    /// A recorder that plays episodes again in `env`.
    pub fn new(every: NonZeroU64, folder: &Path, info: RecordingInfo, env: E) -> Self {
        let player = Player::new(env, info.reach_distance);
        Self { every, folder: folder.to_owned(), info, player, file: None }
    }

    /// The first episode of the run, and then every K-th.
    pub fn wants(&self, episode: u64) -> bool {
        episode.is_multiple_of(self.every.get())
    }

    /// Records an episode.
    pub fn record(&mut self, script: &ActionLog) -> Result<(), RecorderError> {
        let file = match &mut self.file {
            Some(file) => file,
            empty => {
                // A resumed run has another first episode, and does not write over this file.
                let name = format!("episodes-{}.mcap", script.number);
                let file = RecordingFile::create(&self.folder.join(name), &self.info);
                empty.insert(file.map_err(RecorderError::Write)?)
            }
        };
        let messages = self.player.messages(script, file.next()).map_err(RecorderError::Play)?;
        file.add(&messages).map_err(RecorderError::Write)
    }

    /// Stops after an error; the file that keeps the whole episodes, if there are any.
    pub fn stop(self) -> Option<PathBuf> {
        self.file.and_then(RecordingFile::keep_whole)
    }

    /// Gives the recording its name; how many episodes are in it, and where it is.
    pub fn finish(self) -> Result<Option<(u64, PathBuf)>, FileError> {
        self.file.map(|file| Ok((file.episodes(), file.finish()?))).transpose()
    }
}
