//! A trained policy and all that is known about it, from a run folder or a policy file.

use crate::errors::{ForeignTask, OtherRun};
use crate::printer::Printer;
use crate::shipped;
use anyhow::Context as _;
use rher_core::config::TestPolicy;
use rher_core::files::FileError;
use rher_core::policy::Critic;
use rher_core::policy::Policy;
use rher_core::train::checkpoint::{self, CheckpointError, POLICY_FILE};
use rher_core::{RunId, run_id};
use rher_envs::{Options, Task};
use rher_record::RecordingInfo;
use rher_runs::{CONFIG_FILE, ConfigFile, Settings, settings};
use sha2::{Digest as _, Sha256};
use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A policy that acts in the environments of a task.
pub(crate) struct Trained {
    pub(crate) policy: Policy,
    pub(crate) task: Task,
    /// What its environments were made with.
    pub(crate) options: Options,
    file_sha256: String,
    folder: Option<PathBuf>,
    run: Option<Settings>,
}

impl Trained {
    /// Loads a run folder, a policy file, or the policy that ships with the program for a task.
    pub(crate) fn load(path: &Path, printer: Printer) -> anyhow::Result<Self> {
        let place = shipped::folder(path, printer)?;
        let path = &*place;
        let folder = path.is_dir().then_some(path);
        let file = folder.map_or_else(|| path.to_owned(), |folder| folder.join(POLICY_FILE));
        let policy = Policy::load(&file)?;
        let name = policy.info().task.clone();
        let task: Task = name.parse().map_err(|_| ForeignTask { name })?;
        let options = made_with(&policy.info().variant, task)?;
        let run = match (folder, file.parent()) {
            (Some(folder), _) => settings_of(folder, &policy, task)?,
            // A file may lie in the folder of its run; where it lies elsewhere is no matter.
            (None, Some(beside)) => settings_of(beside, &policy, task).ok().flatten(),
            (None, None) => None,
        };
        let bytes = std::fs::read(&file).map_err(FileError::read(&file))?;
        let file_sha256 = sha256(&bytes);
        let folder = folder.map(Path::to_owned);
        if let Cow::Owned(_) = place {
            // All of it is in memory now, so that nothing stays behind whatever ends the program.
            shipped::remove();
        }
        Ok(Self { policy, task, options, file_sha256, folder, run })
    }

    /// What the learner of the run expects of actions.
    ///
    /// A policy file alone has no critic, and a run whose checkpoint was deleted or is of another
    /// version still has a good policy. A checkpoint that cannot be read is an error.
    pub(crate) fn critic(&self) -> Result<Option<Critic>, CheckpointError> {
        match self.folder.as_deref().map(checkpoint::read_critic).transpose() {
            Err(CheckpointError::Missing { .. } | CheckpointError::Version { .. }) => Ok(None),
            critic => critic,
        }
    }

    /// Which policy stands for the task.
    pub(crate) fn test_policy(&self) -> TestPolicy {
        self.run.as_ref().map_or(TestPolicy::Final, |run| run.config.exploration.test_policy)
    }

    /// Seed of the episodes that the evaluations of training had; `None` where nobody knows.
    pub(crate) fn training_seed(&self) -> Option<u64> {
        self.run.as_ref().map(|run| run.config.evaluation.env_seed)
    }

    /// Adds to what a recording says of itself where its policy comes from.
    pub(crate) fn describe(&self, info: &mut RecordingInfo) -> anyhow::Result<()> {
        info.policy_sha256.clone_from(&self.file_sha256);
        info.run = self.policy.run();
        if let Some(run) = &self.run {
            info.config = settings::to_toml(run)?;
        }
        Ok(())
    }
}

/// The settings of the run in `folder`, of which `policy` must be: those in its settings file, or in
/// its checkpoint where there is no such file; `None` in a folder that has neither.
fn settings_of(folder: &Path, policy: &Policy, task: Task) -> anyhow::Result<Option<Settings>> {
    let check = |file: &'static str, run: Option<RunId>| match (policy.run(), run) {
        (Some(policy), Some(other)) if policy != other => {
            Err(OtherRun { folder: folder.to_owned(), policy, file, other })
        }
        _ => Ok(()),
    };
    if let Some(file) = ConfigFile::read(folder)? {
        check(CONFIG_FILE, file.run)?;
        return Ok(Some(file.settings()?));
    }
    match checkpoint::read_config(folder) {
        Ok(config) => {
            let variant = checkpoint::read_variant(folder)?;
            check("checkpoint", Some(run_id(&config, &variant)))?;
            Ok(Some(Settings { config, options: made_with(&variant, task)? }))
        }
        Err(CheckpointError::Missing { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// The options that an environment of `task` was made with, from what runs and policies remember.
pub(crate) fn made_with(variant: &str, task: Task) -> anyhow::Result<Options> {
    if variant.is_empty() {
        return Ok(Options::of(task.options()));
    }
    variant.parse().with_context(|| format!("cannot read the options of `{task}`: {variant}"))
}

/// The warning that a recording was read up to its last whole episode.
pub(crate) fn unfinished(path: &Path) -> String {
    format!("`{}` is not finished: an episode at its end may be left out", path.display())
}

/// As `sha256sum` prints it.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
