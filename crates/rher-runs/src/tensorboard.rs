//! Event files for `TensorBoard`: every number of the metrics, by environment steps.
//!
//! A file is a row of records: the length (8 bytes, little endian), its checksum, the bytes, their
//! checksum. The bytes are a `tensorflow.Event` in protocol buffers' wire format.

use rher_core::event::Metrics;
use rher_core::files::FileError;
use serde_json::Value;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Folder of the event files in a run folder.
const FOLDER: &str = "tensorboard";

/// How the names of event files begin; the seconds since 1970 follow, with ten digits.
const PREFIX: &str = "events.out.tfevents.";

/// The first event says which format follows.
const VERSION: &str = "brain.Event:2";

/// One event file, open at its end.
#[derive(Debug)]
pub struct EventFile {
    path: PathBuf,
    file: File,
}

impl EventFile {
    /// A new file in a run folder, of training from `env_steps` on: `TensorBoard` forgets what
    /// earlier files say of later steps.
    pub fn create(run: &Path, env_steps: u64) -> Result<Self, FileError> {
        let folder = run.join(FOLDER);
        std::fs::create_dir_all(&folder).map_err(FileError::write(&folder))?;
        let now = since_epoch();
        let (file, path) = loop {
            let names = names_in(&folder).map_err(FileError::write(&folder))?;
            let path = folder.join(name_after(&names, now as u64));
            match File::create_new(&path) {
                // Another process has just taken it.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                made => break (made.map_err(FileError::write(&path))?, path),
            }
        };
        let mut events = Self { path, file };
        let mut version = Message::event(now, 0);
        version.bytes(3, VERSION.as_bytes());
        let mut session = Message::default();
        session.integer(1, 1);
        // What was written for this step itself stays.
        let mut start = Message::event(now, env_steps + 1);
        start.bytes(7, &session.0);
        events.write(&[version, start])?;
        Ok(events)
    }

    /// Writes one event with every number of `metrics`.
    pub fn append(&mut self, metrics: &Metrics) -> Result<(), FileError> {
        let mut summary = Message::default();
        let value = serde_json::to_value(metrics).map_err(|error| self.failed(error.into()))?;
        each_number("", &value, &mut |tag, number| {
            let mut scalar = Message::default();
            scalar.bytes(1, tag.as_bytes());
            scalar.float(2, number as f32);
            summary.bytes(1, &scalar.0);
        });
        let mut event = Message::event(since_epoch(), metrics.env_steps);
        event.bytes(5, &summary.0);
        self.write(&[event])
    }

    fn write(&mut self, events: &[Message]) -> Result<(), FileError> {
        let records: Vec<u8> = events.iter().flat_map(|Message(event)| record(event)).collect();
        self.file.write_all(&records).map_err(|source| self.failed(source))
    }

    fn failed(&self, source: io::Error) -> FileError {
        FileError::write(&self.path)(source)
    }
}

/// The names of the event files in a folder.
fn names_in(folder: &Path) -> io::Result<Vec<String>> {
    let names = std::fs::read_dir(folder)?
        .map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let names: io::Result<Vec<String>> = names.collect();
    Ok(names?.into_iter().filter(|name| name.starts_with(PREFIX)).collect())
}

/// A name that comes after all others, since files are read in the order of their names; the clock
/// may have gone back since they were written.
fn name_after(names: &[String], seconds: u64) -> String {
    let name = |seconds: u64| format!("{PREFIX}{seconds:010}.000.rher");
    let seconds_of =
        |name: &String| name.get(PREFIX.len()..)?.split('.').next()?.parse::<u64>().ok();
    let latest = names.iter().filter_map(seconds_of).max().unwrap_or(0);
    let seconds = seconds.max(latest);
    if names.iter().all(|other| *other < name(seconds)) { name(seconds) } else { name(seconds + 1) }
}

fn since_epoch() -> f64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

/// Every number in a JSON value with the way to it, as in `success/1`; lists count from 1.
fn each_number(tag: &str, value: &Value, visit: &mut impl FnMut(&str, f64)) {
    let below = |name: &str| if tag.is_empty() { name.to_owned() } else { format!("{tag}/{name}") };
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                each_number(&below(name), value, visit);
            }
        }
        Value::Array(values) => {
            for (index, value) in values.iter().enumerate() {
                each_number(&below(&(index + 1).to_string()), value, visit);
            }
        }
        Value::Number(number) => visit(tag, number.as_f64().unwrap_or(f64::NAN)),
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// A message of protocol buffers.
#[derive(Default)]
struct Message(Vec<u8>);

impl Message {
    /// A `tensorflow.Event` without content.
    fn event(seconds: f64, step: u64) -> Self {
        let mut event = Self::default();
        event.key(1, 1);
        event.0.extend(seconds.to_le_bytes());
        event.integer(2, step);
        event
    }

    /// Begins field `number`: wire type 0 is an integer, 1 eight bytes, 2 a length, 5 four bytes.
    fn key(&mut self, number: u8, wire_type: u8) {
        self.0.push(number << 3 | wire_type);
    }

    fn integer(&mut self, number: u8, value: u64) {
        self.key(number, 0);
        self.varint(value);
    }

    fn float(&mut self, number: u8, value: f32) {
        self.key(number, 5);
        self.0.extend(value.to_le_bytes());
    }

    /// A text or a message.
    fn bytes(&mut self, number: u8, value: &[u8]) {
        self.key(number, 2);
        self.varint(value.len() as u64);
        self.0.extend(value);
    }

    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }
}

fn record(bytes: &[u8]) -> Vec<u8> {
    let length = (bytes.len() as u64).to_le_bytes();
    let sums = [masked(&length), masked(bytes)].map(u32::to_le_bytes);
    [&length, sums[0].as_slice(), bytes, &sums[1]].concat()
}

/// A checksum that is not disturbed by checksums in what is summed.
fn masked(bytes: &[u8]) -> u32 {
    crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

/// Castagnoli's checksum, bit by bit: a few kilobytes are written in each minute.
fn crc32c(bytes: &[u8]) -> u32 {
    const REFLECTED: u32 = 0x82f6_3b78;
    !bytes.iter().fold(!0_u32, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (REFLECTED * (sum & 1)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_castagnolis() {
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
        assert_eq!(crc32c(&[0xff; 32]), 0x62a8_ab43);
    }

    #[test]
    fn a_new_file_is_read_after_all_others() {
        let names = |names: &[&str]| -> Vec<String> {
            names.iter().map(|name| format!("{PREFIX}{name}")).collect()
        };
        for (there, seconds, expected) in [
            (names(&[]), 1_795_821_391, "1795821391.000.rher"),
            (names(&["1795821390.000.rher"]), 1_795_821_391, "1795821391.000.rher"),
            // Twice in a second.
            (names(&["1795821391.000.rher"]), 1_795_821_391, "1795821392.000.rher"),
            // The clock has gone back.
            (names(&["1795821391.000.rher", "17.host"]), 5, "1795821392.000.rher"),
            (names(&["1795821391.1234.other.0"]), 5, "1795821392.000.rher"),
        ] {
            let name = name_after(&there, seconds);
            assert_eq!(name, format!("{PREFIX}{expected}"));
            assert!(there.iter().all(|other| *other < name), "{there:?}");
        }
    }

    #[test]
    fn tags_are_the_way_to_a_number() {
        let mut seen = Vec::new();
        let value = serde_json::json!({"a": 1, "b": [null, 0.5], "c": {"d": 2}, "e": "x"});
        each_number("", &value, &mut |tag, number| seen.push((tag.to_owned(), number)));
        let expected = [("a", 1.0), ("b/2", 0.5), ("c/d", 2.0)];
        assert_eq!(seen, expected.map(|(tag, number)| (tag.to_owned(), number)));
    }

    #[test]
    fn integers_are_written_seven_bits_at_a_time() {
        let mut message = Message::default();
        message.integer(2, 300);
        assert_eq!(message.0, [0x10, 0xac, 0x02]);
    }
}
