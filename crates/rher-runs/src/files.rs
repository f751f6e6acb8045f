//! What a run writes beside its checkpoint, whoever runs its trainer.

use crate::folder::{RunDir, RunDirError};
use crate::metrics::{MetricsError, MetricsFile};
use crate::settings::Settings;
use rher_core::config::TrainConfig;
use rher_core::event::{Event, Observer, ObserverError};
use rher_core::files::FileError;
use rher_core::train::Trainer;
use rher_core::{Env, RunId};
use rher_envs::Options;
use std::path::Path;

/// Makes the folder of a run whole: with it as observer, `Trainer::run` leaves the same files as
/// `rher train`, and `rher runs`, `stats`, `plot` and `report` read them.
///
/// ```no_run
/// use rher_runs::{RunDir, RunFiles};
/// # fn train<E: rher_core::Env<1> + 'static>(
/// #     mut trainer: rher_core::Trainer<1, E>,
/// # ) -> Result<(), Box<dyn std::error::Error>> {
/// # let stop = std::sync::atomic::AtomicBool::new(false);
/// let folder = RunDir::create("runs/mine".as_ref())?;
/// let mut files = RunFiles::new(folder, &trainer)?;
/// trainer.run(Some("runs/mine".as_ref()), &mut files, &stop)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct RunFiles {
    folder: RunDir,
    run: RunId,
    settings: Settings,
    metrics: MetricsFile,
}

impl RunFiles {
    /// Writes the settings of the run into its folder, which was
    /// [created](RunDir::create) for this trainer or [opened](RunDir::open) before it was resumed.
    ///
    /// # Errors
    ///
    /// If the file system refuses, or if lines of metrics that the checkpoint knows of are missing
    /// or damaged.
    pub fn new<E: Env<N> + 'static, const N: usize>(
        folder: RunDir,
        trainer: &Trainer<N, E>,
    ) -> Result<Self, RunFilesError> {
        let options: Option<Options> = trainer.spec().variant.parse().ok();
        let (config, options) = (trainer.config().clone(), options.unwrap_or_default());
        let settings = Settings { config, options };
        let metrics = match trainer.evaluations() {
            0 => MetricsFile::create(&folder.metrics(), trainer.id())?,
            count => MetricsFile::resume(&folder.metrics(), trainer.id(), count)?,
        };
        folder.write_config(&settings, trainer.id())?;
        Ok(Self { folder, run: trainer.id(), settings, metrics })
    }

    /// Writes the settings once more, after what ends the run was changed.
    ///
    /// # Errors
    ///
    /// If the file system refuses.
    pub fn set_config(&mut self, config: &TrainConfig) -> Result<(), RunDirError> {
        self.settings.config = config.clone();
        self.folder.write_config(&self.settings, self.run)
    }

    /// The folder.
    pub fn folder(&self) -> &RunDir {
        &self.folder
    }

    /// The settings of the run.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Where the folder is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Gives the folder back to other processes, see [`RunDir::close`].
    pub fn close(self) -> Result<(), FileError> {
        self.folder.close()
    }
}

impl Observer for RunFiles {
    fn on(&mut self, event: &Event) -> Result<(), ObserverError> {
        // What is written must be beside what was written before.
        if matches!(event, Event::Evaluated(_) | Event::Saving) {
            self.folder.check().map_err(|error| ObserverError(error.into()))?;
        }
        match event {
            Event::Evaluated(line) => {
                self.metrics.append(line).map_err(|error| ObserverError(error.into()))
            }
            _ => Ok(()),
        }
    }
}

/// The files of a run cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum RunFilesError {
    /// Its folder.
    #[error(transparent)]
    Folder(#[from] RunDirError),
    /// Its metrics.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
}
