//! The description of a recording: what all of its episodes have in common.

use rher_core::RunId;
use rher_core::env::EnvSpec;
use rher_core::goal::Leg;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the format: topics, messages and this description.
pub(crate) const VERSION: u32 = 1;

/// Name of the metadata record.
pub(crate) const RECORD: &str = "rher";

/// Where episodes come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Training, exploration included.
    Training,
    /// A finished policy.
    Policy,
}

/// What holds for all episodes of a recording: a metadata record of text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingInfo {
    /// Name of the task.
    pub task: String,
    /// Options that its environments were made with, as [`rher_envs::Options`] writes them.
    pub options: String,
    /// Where the episodes come from.
    pub source: Source,
    /// Seed of the run, or of the episodes that were played.
    #[serde(with = "as_text")]
    pub seed: u64,
    /// The paper's d: how near the gripper counts as at an object when stages are recorded, in
    /// meters.
    #[serde(with = "as_text")]
    pub reach_distance: f32,
    /// Sub-tasks of the task.
    #[serde(with = "as_text")]
    pub subtasks: usize,
    /// The run that trains or that trained the policy; earlier versions did not write it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<RunId>,
    /// Settings of the run as TOML; empty where they are not known.
    #[serde(default)]
    pub config: String,
    /// SHA-256 of the policy file; empty in training, where every episode has a policy of its own.
    #[serde(default)]
    pub policy_sha256: String,
    /// Version of this program.
    pub rher: String,
    /// Version of the physics engine.
    pub rapier: String,
}

/// The record as it lies in the file.
#[derive(Serialize, Deserialize)]
struct Versioned {
    #[serde(with = "as_text")]
    version: u32,
    #[serde(flatten)]
    info: RecordingInfo,
}

/// A description cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum InfoError {
    /// It is of another version.
    #[error("it has version {found}, expected {VERSION}")]
    Version {
        /// Its version.
        found: String,
    },
    /// Something is missing or not what it should be.
    #[error("its metadata record `{RECORD}`: {0}")]
    Malformed(#[from] serde_json::Error),
}

impl RecordingInfo {
    /// Describes a recording that this program makes; the caller adds settings and policy.
    pub fn new<const N: usize>(
        spec: &EnvSpec<N>,
        source: Source,
        seed: u64,
        reach_distance: f32,
    ) -> Self {
        Self {
            task: spec.name.clone(),
            options: spec.variant.clone(),
            source,
            seed,
            reach_distance,
            subtasks: spec.subtasks,
            run: None,
            config: String::new(),
            policy_sha256: String::new(),
            rher: env!("CARGO_PKG_VERSION").to_owned(),
            rapier: rher_envs::RAPIER_VERSION.to_owned(),
        }
    }

    /// Whether the last sub-task reaches an object or places one.
    pub fn last_leg(&self) -> Leg {
        Leg::of_subtask(self.subtasks.saturating_sub(1))
    }

    pub(crate) fn to_record(&self) -> BTreeMap<String, String> {
        let versioned = Versioned { version: VERSION, info: self.clone() };
        let value = serde_json::to_value(versioned).and_then(serde_json::from_value);
        value.expect("every entry is text")
    }

    pub(crate) fn from_record(record: &BTreeMap<String, String>) -> Result<Self, InfoError> {
        let found = record.get("version").cloned().unwrap_or_default();
        if found != VERSION.to_string() {
            return Err(InfoError::Version { found });
        }
        let value = serde_json::to_value(record)?;
        Ok(serde_json::from_value::<Versioned>(value)?.info)
    }
}

/// Numbers as text, which metadata records are made of, and in which no reader loses a digit.
pub(crate) mod as_text {
    use serde::de::Error;
    use serde::{Deserialize as _, Deserializer, Serializer};
    use std::fmt::Display;
    use std::str::FromStr;

    pub(crate) fn serialize<S: Serializer>(
        number: &impl Display,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_str(number)
    }

    pub(crate) fn deserialize<'de, T, D>(deserializer: D) -> Result<T, D::Error>
    where
        T: FromStr<Err: Display>,
        D: Deserializer<'de>,
    {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}
