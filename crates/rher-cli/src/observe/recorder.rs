//! Recordings of training episodes, exploration included.

use rher_core::event::ObserverError;
use rher_core::explore::ActionLog;
use rher_core::files::FileError;
use rher_envs::Simulated;
use rher_record::{About, Player, RecordingFile};
use rher_runs::RunDir;
use std::num::NonZeroU64;
use std::path::PathBuf;

/// Records every so many training episodes in the folder of their run.
pub(crate) struct Recorder<E, const N: usize> {
    every: NonZeroU64,
    folder: PathBuf,
    about: About,
    player: Player<E, N>,
    /// `None` until there is an episode.
    file: Option<RecordingFile>,
}

impl<const N: usize, E: Simulated<N>> Recorder<E, N> {
    /// A recorder that plays episodes again in `env`.
    pub(crate) fn new(every: NonZeroU64, folder: &RunDir, about: About, env: E) -> Self {
        let player = Player::new(env, about.reach_distance);
        Self { every, folder: folder.path().to_owned(), about, player, file: None }
    }

    /// The first episode of the run, and then one in so many.
    pub(crate) fn wants(&self, episode: u64) -> bool {
        episode.is_multiple_of(self.every.get())
    }

    /// Records an episode.
    pub(crate) fn record(&mut self, script: &ActionLog) -> Result<(), ObserverError> {
        let file = match &mut self.file {
            Some(file) => file,
            empty => {
                // A run that goes on has another first episode, and does not write over this file.
                let name = format!("episodes-{}.mcap", script.number);
                let file = RecordingFile::create(&self.folder.join(name), &self.about);
                empty.insert(file.map_err(|error| ObserverError(error.into()))?)
            }
        };
        let messages = self.player.tell(script, file.next());
        let messages = messages.map_err(|error| ObserverError(error.into()))?;
        file.add(&messages).map_err(|error| ObserverError(error.into()))
    }

    /// Gives the recording its name; how many episodes are in it, and where it is.
    pub(crate) fn finish(self) -> Result<Option<(u64, PathBuf)>, FileError> {
        self.file.map(|file| Ok((file.episodes(), file.finish()?))).transpose()
    }
}
