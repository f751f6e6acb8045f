//! `metrics.jsonl`: what every evaluation found, one JSON object in a line.
//!
//! The last two values of a line are the run that it is of and the CRC-32 of what stands before it,
//! so that a changed line is noticed. Earlier versions wrote neither.

use rher_core::RunId;
use rher_core::event::Metrics;
use rher_core::files::{self, FileError, is_absent};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::fs::{File, OpenOptions};
use std::io::{self, Seek as _, Write as _};
use std::path::{Path, PathBuf};

/// One line for each evaluation.
pub const METRICS_FILE: &str = "metrics.jsonl";

/// Largest file in bytes: that of some 300,000 evaluations.
const LARGEST: u64 = 1 << 28;

/// What stands before the eight digits of a line's checksum, and after them.
const CHECKSUM: (&str, &str) = (",\"crc32\":\"", "\"}");

/// What one line says of success.
#[derive(Clone, Debug, Deserialize)]
pub struct Evaluation {
    /// Environment steps of training before it.
    pub env_steps: u64,
    /// Seconds of training before it.
    pub wall_s: f64,
    /// Success rate of each sub-task; `None` where it is not trained. At least one.
    pub success: Vec<Option<f64>>,
    /// Success rate of the whole task.
    pub success_final: f64,
    /// The run that it is of; earlier versions did not write it.
    pub run: Option<RunId>,
}

/// The metrics of a run cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MetricsError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no file.
    #[error("there is no `{}`", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// A line is not what was written.
    #[error("line {line} of `{}` is damaged: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
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

/// The file, open at its end.
#[derive(Debug)]
pub struct MetricsFile {
    path: PathBuf,
    run: RunId,
    file: File,
}

impl MetricsFile {
    /// An empty file for the metrics of `run`.
    pub fn create(path: &Path, run: RunId) -> Result<Self, FileError> {
        let file = File::create(path).map_err(FileError::write(path))?;
        Ok(Self { path: path.to_owned(), run, file })
    }

    /// The file of a run whose checkpoint knows of `evaluations` lines; later ones are cut off,
    /// since they will be written again.
    ///
    /// # Errors
    ///
    /// If one of these lines is missing, damaged or of another run.
    pub fn resume(path: &Path, run: RunId, evaluations: u64) -> Result<Self, MetricsError> {
        let text = read_text(path)?;
        let complete = text.split_inclusive(|byte| *byte == b'\n').filter(|line| is_complete(line));
        let lines: Vec<&[u8]> =
            complete.take(usize::try_from(evaluations).unwrap_or(usize::MAX)).collect();
        let found = lines.len() as u64;
        if found < evaluations {
            let expected = evaluations;
            return Err(MetricsError::TooShort { path: path.to_owned(), found, expected });
        }
        parse(path, lines.iter().copied(), Some(run))?;
        let kept = lines.iter().map(|line| line.len() as u64).sum();
        let open = || {
            let mut file = OpenOptions::new().write(true).open(path)?;
            file.set_len(kept)?;
            file.seek(io::SeekFrom::End(0))?;
            Ok(file)
        };
        let file = open().map_err(FileError::write(path))?;
        Ok(Self { path: path.to_owned(), run, file })
    }

    /// Writes one line, and sees it onto the disk: a checkpoint will count on it.
    pub fn append(&mut self, metrics: &Metrics) -> Result<(), FileError> {
        let line = serde_json::to_string(metrics).map_err(io::Error::from);
        line.and_then(|line| {
            self.file.write_all(signed(&line, self.run).as_bytes())?;
            files::sync(&self.file)
        })
        .map_err(FileError::write(&self.path))
    }
}

/// A JSON object as a line that names its run and has a checksum.
fn signed(object: &str, run: RunId) -> String {
    let fields = object.strip_suffix('}').expect("metrics are a JSON object");
    let line = format!("{fields},\"run\":\"{run}\"");
    let checksum = crc32fast::hash(line.as_bytes());
    let (before, after) = CHECKSUM;
    line + before + &format!("{checksum:08x}") + after + "\n"
}

/// The evaluations of a run, in the order in which they were made; there may be none yet.
///
/// `run` is the one whose folder it is, if its settings say that.
///
/// # Errors
///
/// If the file is missing or damaged, or if a line is of another run.
pub fn read_evaluations(
    folder: &Path,
    run: Option<RunId>,
) -> Result<Vec<Evaluation>, MetricsError> {
    let path = folder.join(METRICS_FILE);
    let text = read_text(&path)?;
    let mut lines: Vec<&[u8]> = text.split_inclusive(|byte| *byte == b'\n').collect();
    // What is written at this moment may be a part of a line, and is none of the evaluations.
    let is_whole = |line: &[u8]| is_complete(line) || parse(&path, [line].into_iter(), run).is_ok();
    if lines.last().is_some_and(|line| !is_whole(line)) {
        lines.pop();
    }
    parse(&path, lines.into_iter(), run)
}

/// Everything that the evaluations of a run say, by key, in the order in which they were made.
///
/// # Errors
///
/// As [`read_evaluations`].
pub fn read_metrics(
    folder: &Path,
    run: Option<RunId>,
) -> Result<Vec<Map<String, Value>>, MetricsError> {
    let count = read_evaluations(folder, run)?.len();
    let path = folder.join(METRICS_FILE);
    let text = read_text(&path)?;
    let lines = text.split(|byte| *byte == b'\n').take(count).enumerate();
    lines
        .map(|(index, line)| {
            serde_json::from_slice(line).map_err(|error| MetricsError::Damaged {
                path: path.clone(),
                line: index + 1,
                problem: error.to_string(),
            })
        })
        .collect()
}

fn is_complete(line: &[u8]) -> bool {
    line.ends_with(b"\n")
}

fn read_text(path: &Path) -> Result<Vec<u8>, MetricsError> {
    files::read_at_most(path, LARGEST).map_err(|error| {
        if is_absent(&error.source) {
            MetricsError::Missing { path: path.to_owned() }
        } else {
            error.into()
        }
    })
}

/// Lines that follow each other in the metrics of a run.
fn parse<'a>(
    path: &Path,
    lines: impl Iterator<Item = &'a [u8]>,
    run: Option<RunId>,
) -> Result<Vec<Evaluation>, MetricsError> {
    let mut evaluations: Vec<Evaluation> = Vec::new();
    for (index, line) in lines.enumerate() {
        let damaged =
            |problem| MetricsError::Damaged { path: path.to_owned(), line: index + 1, problem };
        let evaluation = parse_line(line, run).map_err(damaged)?;
        evaluation.check(evaluations.last()).map_err(damaged)?;
        evaluations.push(evaluation);
    }
    Ok(evaluations)
}

fn parse_line(line: &[u8], expected: Option<RunId>) -> Result<Evaluation, String> {
    let line = str::from_utf8(line).map_err(|_| "it is no text".to_owned())?.trim_end();
    let evaluation: Evaluation = serde_json::from_str(line).map_err(|error| error.to_string())?;
    let (before, after) = CHECKSUM;
    let signature = line.rsplit_once(before);
    if evaluation.run.is_none() && signature.is_none() {
        return Ok(evaluation);
    }
    let digits = signature.and_then(|(text, end)| Some((text, end.strip_suffix(after)?)));
    let (text, expected_sum) = digits.ok_or("its checksum is missing")?;
    let found = format!("{:08x}", crc32fast::hash(text.as_bytes()));
    if found != expected_sum {
        return Err(format!("its checksum is {found}, expected {expected_sum}"));
    }
    match (expected, evaluation.run) {
        (Some(expected), Some(run)) if expected != run => {
            Err(format!("it is of run {run}, but the folder is that of run {expected}"))
        }
        _ => Ok(evaluation),
    }
}

impl Evaluation {
    /// Whether the whole task succeeded at least this often.
    pub fn reaches(&self, rate: f64) -> bool {
        // Rates are written with the digits of a single-precision number.
        const ROUNDING: f64 = 1e-6;
        self.success_final >= rate - ROUNDING
    }

    /// Whether this can follow `before` in the metrics of a run; if not, what is wrong.
    fn check(&self, before: Option<&Self>) -> Result<(), String> {
        if self.success.is_empty() {
            return Err("`success` is empty, expected a rate for each sub-task".to_owned());
        }
        let rates = self.success.iter().copied().flatten().chain([self.success_final]);
        if let Some(rate) = rates.into_iter().find(|rate| !(0.0..=1.0).contains(rate)) {
            return Err(format!("a success rate is {rate}, expected 0 to 1"));
        }
        if !(self.wall_s.is_finite() && self.wall_s >= 0.0) {
            return Err(format!("`wall_s` is {}, expected at least 0", self.wall_s));
        }
        match before {
            Some(before) if before.env_steps > self.env_steps => Err(format!(
                "`env_steps` is {}, expected at least the {} of the line before",
                self.env_steps, before.env_steps
            )),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OBJECT: &str =
        r#"{"env_steps":100,"wall_s":1.5,"success":[0.5],"success_final":0.5,"time":{"save":0.1}}"#;

    fn run(last: u8) -> RunId {
        format!("{:032x}", u128::from(last)).parse().unwrap()
    }

    #[test]
    fn every_flipped_bit_of_a_line_is_noticed() {
        let line = signed(OBJECT, run(1));
        assert!(line.ends_with("\"}\n") && line.contains("0.1},\"run\""), "{line}");
        assert!(parse_line(line.as_bytes(), Some(run(1))).is_ok());
        for bit in 0..8 * (line.len() - 1) {
            let mut damaged = line.clone().into_bytes();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(parse_line(&damaged, None).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn lines_of_another_run_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(METRICS_FILE);
        std::fs::write(&path, signed(OBJECT, run(1))).unwrap();
        assert_eq!(read_evaluations(folder.path(), None).unwrap().len(), 1);
        assert_eq!(read_evaluations(folder.path(), Some(run(1))).unwrap().len(), 1);
        let error = read_evaluations(folder.path(), Some(run(2))).unwrap_err().to_string();
        assert!(error.contains("is of run"), "{error}");
        assert!(MetricsFile::resume(&path, run(2), 1).is_err());
        assert!(MetricsFile::resume(&path, run(1), 1).is_ok());
    }

    #[test]
    fn a_line_without_its_end_counts_if_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(METRICS_FILE);
        let line = signed(OBJECT, run(1));
        std::fs::write(&path, line.trim_end()).unwrap();
        assert_eq!(read_evaluations(folder.path(), None).unwrap().len(), 1);
        std::fs::write(&path, line.clone() + &line[..line.len() / 2]).unwrap();
        assert_eq!(read_evaluations(folder.path(), None).unwrap().len(), 1);
        // A line in the middle is never left out.
        std::fs::write(&path, format!("{}\n{line}", &line[..line.len() / 2])).unwrap();
        assert!(read_evaluations(folder.path(), None).is_err());
    }

    #[test]
    fn a_run_is_not_resumed_from_damaged_lines() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(METRICS_FILE);
        let line = signed(OBJECT, run(1));
        std::fs::write(&path, line.replace("0.5,\"time\"", "0.6,\"time\"")).unwrap();
        let error = MetricsFile::resume(&path, run(1), 1).unwrap_err().to_string();
        assert!(error.contains("line 1") && error.contains("checksum"), "{error}");
        // What the checkpoint does not know of is cut off, whatever it is.
        std::fs::write(&path, format!("{line}no json\nand more")).unwrap();
        MetricsFile::resume(&path, run(1), 1).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), line);
    }
}
