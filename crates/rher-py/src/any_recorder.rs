//! A recorder of training episodes whose task is known at run time only.

use rher_core::RunId;
use rher_core::explore::ActionLog;
use rher_core::files::FileError;
use rher_envs::{EnvVisitor, OptionError, Simulated, Task};
use rher_record::{Recorder, RecorderError, RecordingInfo, Source};
use rher_runs::{Settings, SettingsError, settings};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};

/// A [`Recorder`], whatever its task.
pub(crate) trait AnyRecorder: Send {
    fn wants(&self, episode: u64) -> bool;

    fn record(&mut self, script: &ActionLog) -> Result<(), RecorderError>;

    fn stop(self: Box<Self>) -> Option<PathBuf>;

    fn finish(self: Box<Self>) -> Result<Option<(u64, PathBuf)>, FileError>;
}

impl<const N: usize, E: Simulated<N>> AnyRecorder for Recorder<E, N> {
    fn wants(&self, episode: u64) -> bool {
        Self::wants(self, episode)
    }

    fn record(&mut self, script: &ActionLog) -> Result<(), RecorderError> {
        Self::record(self, script)
    }

    fn stop(self: Box<Self>) -> Option<PathBuf> {
        Self::stop(*self)
    }

    fn finish(self: Box<Self>) -> Result<Option<(u64, PathBuf)>, FileError> {
        Self::finish(*self)
    }
}

/// What is recorded of a run, and where.
pub(crate) struct Recorded<'a> {
    pub(crate) every: NonZeroU64,
    pub(crate) folder: &'a Path,
    pub(crate) run: RunId,
    pub(crate) settings: &'a Settings,
}

/// A recorder for a run on `task`.
pub(crate) fn build(
    task: Task,
    recorded: Recorded<'_>,
) -> Result<Result<Box<dyn AnyRecorder>, SettingsError>, OptionError> {
    task.visit_with(&recorded.settings.options.clone(), recorded)
}

impl EnvVisitor for Recorded<'_> {
    type Output = Result<Box<dyn AnyRecorder>, SettingsError>;

    fn visit<const N: usize, E: Simulated<N>>(self, build: impl Fn() -> E + Sync) -> Self::Output {
        let Self { every, folder, run, settings } = self;
        let (env, config) = (build(), &settings.config);
        let reach_distance = config.relay.reach_distance;
        let mut info =
            RecordingInfo::new(env.spec(), Source::Training, config.seed, reach_distance);
        info.run = Some(run);
        info.config = settings::to_toml(settings)?;
        Ok(Box::new(Recorder::new(every, folder, info, env)))
    }
}
