//! What settings are, and which of them a user asks for.

use rher_core::config::{EngineKind, Method, Precision, Preset, TrainConfig};
use rher_envs::Options;
use std::path::PathBuf;
use toml::Value;

/// Everything that is part of an experiment: how the agent learns, and in which environments.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How the agent learns.
    pub config: TrainConfig,
    /// Settings of the environments.
    pub options: Options,
}

/// Settings that the user asks for.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Preset to start from.
    pub preset: Option<Preset>,
    /// A settings file.
    pub config: Option<PathBuf>,
    /// Single settings, by dotted key.
    pub set: Vec<(String, Value)>,
    /// Training method.
    pub method: Option<Method>,
    /// Seed of every random draw.
    pub seed: Option<u64>,
    /// Environment steps after which training ends.
    pub env_steps: Option<u64>,
    /// Success rate at which training ends early.
    pub until: Option<f32>,
    /// Compute engine of the networks.
    pub engine: Option<EngineKind>,
    /// Precision of the networks' matrix products.
    pub precision: Option<Precision>,
    /// Environments stepped side by side.
    pub envs: Option<u64>,
}
