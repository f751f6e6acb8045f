//! `metrics.jsonl`: what every evaluation found, one JSON object in a line.

use rher_core::event::Metrics;
use rher_core::files::FileError;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

/// The file, open at its end.
#[derive(Debug)]
pub struct MetricsFile {
    path: PathBuf,
    file: File,
}

/// The metrics of a run cannot be continued.
#[derive(Debug, thiserror::Error)]
pub enum MetricsError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// Lines were lost.
    #[error(
        "`{}` has {found} complete lines, but the checkpoint was made after {expected} evaluations",
        path.display()
    )]
    TooShort {
        /// The file.
        path: PathBuf,
        /// Its complete lines.
        found: u64,
        /// Lines that the checkpoint knows of.
        expected: u64,
    },
}

impl MetricsFile {
    /// An empty file.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        let file = File::create(path).map_err(FileError::write(path))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// The file of a run whose checkpoint knows of `evaluations` lines; later ones are cut off,
    /// since they will be written again.
    pub fn resume(path: &Path, evaluations: u64) -> Result<Self, MetricsError> {
        let unreadable = FileError::read(path);
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(&unreadable)?;
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(&unreadable)?;
        let lines = text.split_inclusive(|&byte| byte == b'\n');
        let complete = lines.filter(|line| line.ends_with(b"\n"));
        let lengths: Vec<u64> = complete.map(|line| line.len() as u64).collect();
        let found = lengths.len() as u64;
        if found < evaluations {
            return Err(MetricsError::TooShort {
                path: path.to_owned(),
                found,
                expected: evaluations,
            });
        }
        let kept = lengths[..evaluations as usize].iter().sum();
        file.set_len(kept)
            .and_then(|()| file.seek(io::SeekFrom::End(0)))
            .map_err(FileError::write(path))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Writes one line, and sees it onto the disk: a checkpoint will count on it.
    pub fn append(&mut self, metrics: &Metrics) -> Result<(), FileError> {
        serde_json::to_vec(metrics)
            .map_err(io::Error::from)
            .and_then(|mut line| {
                line.push(b'\n');
                self.file.write_all(&line)?;
                self.file.sync_data()
            })
            .map_err(FileError::write(&self.path))
    }
}
