//! Settings and folders of runs: the same ones whether the command line or Python starts them.

mod config_file;
mod difference;
mod files;
mod folder;
mod listing;
mod machine;
mod metrics;
mod pretrained;
mod run;
pub mod settings;
pub mod sweep;
mod tensorboard;

pub use config_file::{CONFIG_FILE, ConfigFile, ConfigFileError};
pub use difference::{Departure, OtherSettings, departures, difference};
pub use files::{RunFiles, RunFilesError};
pub use folder::{RunDir, RunDirError, is_in_use};
pub use listing::{Listed, State, list};
pub use machine::Machine;
pub use metrics::{
    Evaluation, METRICS_FILE, MetricsError, MetricsFile, read_evaluations, read_metrics,
};
pub use pretrained::read_pretrained;
pub use run::{Group, Groups, Repeated, Run, RunError};
pub use settings::{Asked, Settings, SettingsError};
pub use tensorboard::EventFile;
