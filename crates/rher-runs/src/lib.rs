//! Settings and folders of runs: the same ones whether the command line or Python starts them.

mod folder;
mod machine;
mod metrics;
pub mod settings;

pub use folder::{CONFIG_FILE, METRICS_FILE, RunDir, RunDirError, read_config};
pub use machine::Machine;
pub use metrics::{MetricsError, MetricsFile};
pub use settings::{Asked, Settings, SettingsError};
