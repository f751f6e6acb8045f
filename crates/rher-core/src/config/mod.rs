//! Settings of a run: everything that is part of the experiment, and nothing that is not.
//!
//! Everything about a setting stands in one place, its declaration: documentation, type, range and
//! the value in each preset. [`TrainConfig::SECTIONS`] lists them as data, from which the help
//! texts and the documents are made.

mod agent;
mod declare;
mod evaluation;
mod exploration;
mod preset;
mod relay;
mod replay;
mod started_from;
mod train;
mod validate;

pub use crate::setting::{Choice, Kind, Range, Section, Setting, SettingVisitor, Value};
pub use agent::{AgentConfig, Deployed, EngineKind, Init, Precision, TargetEvery};
pub use evaluation::EvaluationConfig;
pub use exploration::{ExplorationConfig, TestPolicy, TrainPolicy};
pub use preset::Preset;
pub use relay::{GoalFrame, Method, ObjectOrder, RelayConfig};
pub use replay::{BatchMode, ReplayConfig};
pub use started_from::StartedFrom;
pub use train::{TrainConfig, VERSION};
pub use validate::ConfigError;
