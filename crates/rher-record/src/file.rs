//! Writing a recording: whole at every end of an episode, and under its name once it is finished.

use crate::about::{About, RECORD};
use crate::message::{Timed, Topic};
use crate::player::PAUSE;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions, Writer};
use rher_core::files::FileError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// A layout for Foxglove and Lichtblick, the same for every task.
pub const LAYOUT: &str = include_str!("layout.json");

/// When the first message of a file is sent, in nanoseconds: 0 is "never" to some readers.
const FIRST: u64 = 1_000_000_000;

/// A recording that is being written.
///
/// Until it is finished it lies beside its place, with `.part` in its name. All that was sent of
/// finished episodes is on disk: nothing of it is lost to a `kill -9`.
pub struct RecordingFile {
    path: PathBuf,
    part: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: [u16; Topic::ALL.len()],
    sequence: u32,
    next: u64,
    episodes: u64,
}

impl RecordingFile {
    /// Starts a recording that will have this path.
    pub fn create(path: &Path, about: &About) -> Result<Self, FileError> {
        // The extension stays: what opens a recording should open one that was cut off.
        let part = path.with_extension("part.mcap");
        let file = File::create(&part).map_err(FileError::write(&part))?;
        Self::begin(BufWriter::new(file), about)
            .map(|(writer, channels)| Self {
                path: path.to_owned(),
                part: part.clone(),
                writer,
                channels,
                sequence: 0,
                next: FIRST,
                episodes: 0,
            })
            .map_err(|error| FileError::write(&part)(into_io(error)))
    }

    fn begin(
        file: BufWriter<File>,
        about: &About,
    ) -> Result<(Writer<BufWriter<File>>, [u16; Topic::ALL.len()]), McapError> {
        let mut writer = WriteOptions::new()
            .profile("")
            .library(concat!("rher ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4))
            .create(file)?;
        writer
            .write_metadata(&Metadata { name: RECORD.to_owned(), metadata: about.to_record() })?;
        let mut channels = [0; Topic::ALL.len()];
        for (id, topic) in channels.iter_mut().zip(Topic::ALL) {
            let schema = topic.schema();
            let schema = writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
            *id = writer.add_channel(schema, topic.name(), topic.encoding(), &BTreeMap::new())?;
        }
        Ok((writer, channels))
    }

    /// When the next episode begins, in nanoseconds: later than all that was sent.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// How many episodes are in it.
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// Where it lies until it is finished.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Adds an episode, whose messages are sent from [`next`](Self::next) on.
    pub fn add(&mut self, messages: &[Timed]) -> Result<(), FileError> {
        self.write(messages).map_err(|error| FileError::write(&self.part)(into_io(error)))?;
        self.next = messages.last().map_or(self.next, |last| last.time + PAUSE);
        self.episodes += 1;
        Ok(())
    }

    fn write(&mut self, messages: &[Timed]) -> Result<(), McapError> {
        for Timed { time, message } in messages {
            let channel_id = self.channels[message.topic() as usize];
            let (sequence, log_time) = (self.sequence, *time);
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            self.writer.write_to_known_channel(&header, &message.to_bytes())?;
            self.sequence = self.sequence.wrapping_add(1);
        }
        self.writer.flush()
    }

    /// Gives the recording its name, lays a [`LAYOUT`] beside it, and tells its path.
    pub fn finish(mut self) -> Result<PathBuf, FileError> {
        self.writer.finish().map_err(|error| FileError::write(&self.part)(into_io(error)))?;
        let mut file = self.writer.into_inner();
        file.flush()
            .and_then(|()| file.get_ref().sync_all())
            .map_err(FileError::write(&self.part))?;
        std::fs::rename(&self.part, &self.path).map_err(FileError::write(&self.path))?;
        let layout = layout_beside(&self.path);
        std::fs::write(&layout, LAYOUT).map_err(FileError::write(&layout))?;
        Ok(self.path)
    }

    /// Takes the recording back: nothing stays of it.
    pub fn discard(self) -> Result<(), FileError> {
        let part = self.part;
        drop(self.writer.into_inner());
        std::fs::remove_file(&part).map_err(FileError::write(&part))
    }
}

/// Where the layout of a recording lies.
pub fn layout_beside(recording: &Path) -> PathBuf {
    recording.with_extension("layout.json")
}

fn into_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
