//! Settings of a run: preset < recipe of the task < `--config` < `--set` < other options.

mod asked;
mod describe;
mod error;
mod file;
mod layers;
mod reference;
mod resolve;
mod written;

pub use asked::{Asked, Settings};
pub use describe::{Described, described, list};
pub use error::{Origin, SettingsError, Source};
pub use file::{LARGEST_FILE, read_text};
pub use reference::reference;
pub use resolve::{resolve, resolve_foreign, resolve_here, resolve_options};
pub use written::{Comments, from_table, to_toml, to_toml_with};
