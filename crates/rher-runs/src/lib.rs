//! Settings and folders of runs: the same ones whether the command line or Python starts them.

mod difference;
mod folder;
mod machine;
mod metrics;
mod run;
pub mod settings;

pub use difference::{OtherSettings, difference};
pub use folder::{CONFIG_FILE, METRICS_FILE, RunDir, RunDirError, read_config};
pub use machine::Machine;
pub use metrics::{MetricsError, MetricsFile};
pub use run::{Evaluation, Group, Run, RunError, read_evaluations, read_groups};
pub use settings::{Asked, Settings, SettingsError};
