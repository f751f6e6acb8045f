//! `config.toml` in a run folder: the settings, below a line that names the run and has a checksum.

use crate::settings::{self, Settings, SettingsError};
use rher_core::RunId;
use rher_core::files::{self, FileError, is_absent};
use std::path::{Path, PathBuf};
use toml::Table;

/// The settings of a run.
pub const CONFIG_FILE: &str = "config.toml";

/// How the first line begins; the run and the checksum of all other lines follow.
const FIRST_LINE: &str = "# Run ";
const CHECKSUM: &str = ", CRC-32 of the lines below ";

/// The settings that were kept with a run.
#[derive(Clone, Debug)]
pub struct ConfigFile {
    path: PathBuf,
    /// The run that they are of; earlier versions did not write it.
    pub run: Option<RunId>,
    table: Table,
}

/// The settings that were kept with a run cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigFileError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// They are not what was written.
    #[error("`{}` does not hold the settings of a run: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
}

/// The text of the file for a run with these settings.
pub(crate) fn text(settings: &Settings, run: RunId) -> Result<String, SettingsError> {
    let lines = settings::to_toml(settings)?;
    let checksum = crc32fast::hash(lines.as_bytes());
    Ok(format!("{FIRST_LINE}{run}{CHECKSUM}{checksum:08x}\n{lines}"))
}

impl ConfigFile {
    /// Reads the file of the run in `folder`; `None` if there is none.
    ///
    /// # Errors
    ///
    /// If it cannot be read, is no TOML, or was changed after it was written.
    pub fn read(folder: &Path) -> Result<Option<Self>, ConfigFileError> {
        let path = folder.join(CONFIG_FILE);
        let bytes = match files::read_at_most(&path, settings::LARGEST_FILE) {
            Ok(bytes) => bytes,
            Err(FileError { source, .. }) if is_absent(&source) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        Self::parse(path, bytes).map(Some)
    }

    fn parse(path: PathBuf, bytes: Vec<u8>) -> Result<Self, ConfigFileError> {
        let parsed = || {
            let text = String::from_utf8(bytes).map_err(|_| "it is no text".to_owned())?;
            let run = check(&text)?;
            let table =
                text.parse().map_err(|error: toml::de::Error| error.message().to_owned())?;
            Ok((run, table))
        };
        match parsed() {
            Ok((run, table)) => Ok(Self { path, run, table }),
            Err(problem) => Err(ConfigFileError::Damaged { path, problem }),
        }
    }

    /// The settings as this version of the program knows them.
    ///
    /// # Errors
    ///
    /// If they have another form, as those of another version may.
    pub fn settings(&self) -> Result<Settings, ConfigFileError> {
        settings::from_table(self.table.clone()).map_err(|error| {
            let problem = error.message().to_owned();
            ConfigFileError::Damaged { path: self.path.clone(), problem }
        })
    }

    /// The settings, whatever version of the program wrote them.
    pub fn into_table(self) -> Table {
        self.table
    }
}

/// The run that the first line names, if it does; the other lines must be those that were written.
fn check(text: &str) -> Result<Option<RunId>, String> {
    let Some((first, lines)) = text.strip_prefix(FIRST_LINE).and_then(|text| text.split_once('\n'))
    else {
        return Ok(None);
    };
    let parts = first.split_once(CHECKSUM);
    let parts = parts.and_then(|(run, checksum)| Some((run.parse().ok()?, checksum)));
    let (run, expected) = parts.ok_or("its first line is damaged")?;
    let found = format!("{:08x}", crc32fast::hash(lines.as_bytes()));
    if found == expected {
        Ok(Some(run))
    } else {
        Err(format!(
            "it was changed after it was written: its checksum is {found}, expected \
             {expected}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rher_core::config::Preset;
    use rher_envs::Options;

    fn settings() -> Settings {
        let mut config = Preset::Fast.config("push", 1);
        config.objects = None;
        Settings { config, options: Options::default() }
    }

    #[test]
    fn every_flipped_bit_is_noticed_or_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(CONFIG_FILE);
        assert!(ConfigFile::read(folder.path()).unwrap().is_none());
        let run: RunId = "00112233445566778899aabbccddeeff".parse().unwrap();
        let text = text(&settings(), run).unwrap();
        std::fs::write(&path, &text).unwrap();
        let read = ConfigFile::read(folder.path()).unwrap().unwrap();
        assert_eq!((read.run, read.settings().unwrap().config), (Some(run), settings().config));

        for bit in 8 * FIRST_LINE.len()..8 * text.len() {
            let mut damaged = text.clone().into_bytes();
            damaged[bit / 8] ^= 1 << (bit % 8);
            if let Ok(read) = ConfigFile::parse(path.clone(), damaged) {
                // The digits of the identity are compared with the run's other files.
                assert!(bit / 8 < FIRST_LINE.len() + 32, "bit {bit}");
                assert_eq!(read.settings().unwrap().config, settings().config);
            }
        }
    }

    #[test]
    fn a_file_of_an_earlier_version_has_no_first_line() {
        let folder = tempfile::tempdir().unwrap();
        let lines = settings::to_toml(&settings()).unwrap();
        std::fs::write(folder.path().join(CONFIG_FILE), lines).unwrap();
        let read = ConfigFile::read(folder.path()).unwrap().unwrap();
        assert_eq!(read.run, None);
        assert_eq!(read.settings().unwrap().config, settings().config);
    }
}
