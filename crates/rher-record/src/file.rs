//! Writing a recording: whole at every end of an episode, and under its name once it is finished.

use crate::info::{RECORD, RecordingInfo};
use crate::message::{Timed, Topic};
use crate::part::Part;
use crate::player::PAUSE;
use crate::read::{ReadError, Recorded, Recording, is_unfinished};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions, Writer};
use rher_core::files::{self, FileError};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A layout for Foxglove and Lichtblick, the same for every task.
pub const LAYOUT: &str = include_str!("layout.json");

/// When the first message of a file is sent, in nanoseconds: 0 is "never" to some readers.
const FIRST: u64 = 1_000_000_000;

/// A recording that is being written.
///
/// Until it is finished it lies beside its place, with `.part` in its name. All messages of
/// finished episodes are in the file: nothing of them is lost to a `kill -9`.
pub struct RecordingFile {
    path: PathBuf,
    part: Part,
    refused: Arc<Mutex<Option<io::Error>>>,
    writer: Writer<Output>,
    channels: [u16; Topic::ALL.len()],
    sequence: u32,
    next: u64,
    episodes: u64,
    /// Bytes up to the end of the last whole episode.
    whole: u64,
}

impl RecordingFile {
    /// Starts a recording that will have this path; another one that is being written to the same
    /// path is not disturbed, and the one that is finished last stays.
    ///
    /// # Errors
    ///
    /// If no file can be made beside `path`.
    pub fn create(path: &Path, info: &RecordingInfo) -> Result<Self, FileError> {
        // The extension stays: what opens a recording should open one that was cut off.
        let names = std::iter::once(path.with_extension("part.mcap"))
            .chain((2..1000).map(|n| path.with_extension(format!("{n}.part.mcap"))));
        Self::create_as(path, names, info)
    }

    /// Starts a recording under the first of these names that is free until it is finished.
    fn create_as(
        path: &Path,
        names: impl Iterator<Item = PathBuf>,
        info: &RecordingInfo,
    ) -> Result<Self, FileError> {
        let (part, file) = Part::file(names).map_err(FileError::write(path))?;
        let refused = Arc::default();
        let output = Output { file: BufWriter::new(file), refused: Arc::clone(&refused) };
        match Self::begin(output, info) {
            Ok((writer, channels)) => Ok(Self {
                path: path.to_owned(),
                part,
                refused,
                writer,
                channels,
                sequence: 0,
                next: FIRST,
                episodes: 0,
                whole: 0,
            }),
            Err(error) => {
                // Nothing is in it.
                let _ = std::fs::remove_file(&part.path);
                Err(FileError::write(&part.path)(into_io(error, &refused)))
            }
        }
    }

    fn begin(
        output: Output,
        info: &RecordingInfo,
    ) -> Result<(Writer<Output>, [u16; Topic::ALL.len()]), McapError> {
        let mut writer = WriteOptions::new()
            .profile("")
            .library(concat!("rher ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4))
            .create(output)?;
        writer.write_metadata(&Metadata { name: RECORD.to_owned(), metadata: info.to_record() })?;
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
        &self.part.path
    }

    /// Adds an episode, whose messages are sent from [`next`](Self::next) on.
    ///
    /// # Errors
    ///
    /// If the file cannot be written; then [`keep_whole`](Self::keep_whole) or
    /// [`discard`](Self::discard) it.
    pub fn add(&mut self, messages: &[Timed]) -> Result<(), FileError> {
        self.add_sent(messages.iter().map(|Timed { time, message }| {
            (*time, message.topic(), Cow::Owned(message.to_bytes()))
        }))
    }

    fn add_sent<'a>(
        &mut self,
        messages: impl Iterator<Item = (u64, Topic, Cow<'a, [u8]>)>,
    ) -> Result<(), FileError> {
        let written = self.write(messages);
        written
            .map_err(|error| FileError::write(&self.part.path)(into_io(error, &self.refused)))?;
        self.whole = self.part.bytes().map_err(FileError::write(&self.part.path))?;
        self.episodes += 1;
        Ok(())
    }

    fn write<'a>(
        &mut self,
        messages: impl Iterator<Item = (u64, Topic, Cow<'a, [u8]>)>,
    ) -> Result<(), McapError> {
        for (log_time, topic, bytes) in messages {
            let (channel_id, sequence) = (self.channels[topic as usize], self.sequence);
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            self.writer.write_to_known_channel(&header, &bytes)?;
            self.sequence = self.sequence.wrapping_add(1);
            self.next = log_time + PAUSE;
        }
        self.writer.flush()
    }

    /// Gives the recording its name and puts a [`LAYOUT`] beside it; the path of the recording.
    ///
    /// # Errors
    ///
    /// If a file cannot be written; the recording keeps its `.part` name and its whole episodes.
    pub fn finish(self) -> Result<PathBuf, FileError> {
        let Self { path, part, refused, mut writer, whole, .. } = self;
        let finished = writer.finish().map_err(|error| into_io(error, &refused));
        let mut output = writer.into_inner();
        finished
            .and_then(|_| output.flush())
            .and_then(|()| files::sync(output.file.get_ref()))
            .map_err(FileError::write(&path))
            .and_then(|()| write_layout(&layout_beside(&path)))
            .and_then(|()| std::fs::rename(&part.path, &path).map_err(FileError::write(&path)))
            .inspect_err(|_| {
                let (file, _) = output.file.into_parts();
                let _ = file.set_len(whole);
            })?;
        Ok(path)
    }

    /// Ends the recording after an error: the file keeps its `.part` name and its whole episodes.
    /// The path of the file; none where there is no whole episode, and the file is removed.
    pub fn keep_whole(self) -> Option<PathBuf> {
        let Self { part, writer, episodes, whole, .. } = self;
        // Without what was buffered of the episode that could not be written.
        let (file, _) = writer.into_inner().file.into_parts();
        if episodes == 0 {
            let _ = std::fs::remove_file(&part.path);
            return None;
        }
        // A reader finds the whole episodes also where this fails.
        let _ = file.set_len(whole);
        Some(part.path)
    }

    /// Removes the recording.
    ///
    /// # Errors
    ///
    /// If the file cannot be removed.
    pub fn discard(self) -> Result<(), FileError> {
        let Self { part, writer, .. } = self;
        drop(writer.into_inner());
        std::fs::remove_file(&part.path).map_err(FileError::write(&part.path))
    }

    /// Finishes the recordings in a folder whose writer was killed: their whole episodes get the
    /// name of the recording, and the unfinished files are removed. The names that were given, and
    /// for every unfinished file that stays as it is, why.
    ///
    /// Nobody else may be writing in the folder.
    ///
    /// # Errors
    ///
    /// If the folder cannot be read.
    pub fn recover(folder: &Path) -> Result<Vec<Result<PathBuf, ReadError>>, FileError> {
        let entries = std::fs::read_dir(folder).map_err(FileError::read(folder))?;
        let mut unfinished: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| is_unfinished(path))
            .collect();
        unfinished.sort();
        Ok(unfinished.iter().filter_map(|path| Self::recover_one(path).transpose()).collect())
    }

    /// The name that an unfinished recording was given; `None` if no episode in it is whole.
    fn recover_one(unfinished: &Path) -> Result<Option<PathBuf>, ReadError> {
        let recovered = match Recording::open(unfinished) {
            Err(ReadError::NotMcap { .. } | ReadError::CutOff { whole: 0, .. }) => None,
            opened => Self::rewrite(opened?, unfinished)?,
        };
        std::fs::remove_file(unfinished).map_err(FileError::write(unfinished))?;
        Ok(recovered)
    }

    /// Writes the whole episodes of an unfinished recording under its name.
    fn rewrite(mut recording: Recording, unfinished: &Path) -> Result<Option<PathBuf>, ReadError> {
        let path = unfinished.with_extension("").with_extension("mcap");
        let whole = path.with_extension("whole.mcap");
        let mut file = Self::create_as(&path, std::iter::once(whole.clone()), &recording.info)?;
        let written = loop {
            match recording.next() {
                None => break file.finish().map(Some).map_err(ReadError::from),
                Some(Ok(Recorded { messages, .. })) => {
                    let messages = messages.iter();
                    let sent = messages.map(|it| (it.time, it.topic, Cow::Borrowed(&*it.bytes)));
                    if let Err(error) = file.add_sent(sent) {
                        break Err(error.into());
                    }
                }
                Some(Err(ReadError::CutOff { whole: 0, .. })) => break Ok(None),
                Some(Err(error)) => break Err(error),
            }
        };
        if !matches!(written, Ok(Some(_))) {
            // Its episodes are in the unfinished one.
            let _ = std::fs::remove_file(&whole);
        }
        written
    }
}

/// A file that remembers why it could not be written: the encoder does not pass every reason on.
struct Output {
    file: BufWriter<File>,
    refused: Arc<Mutex<Option<io::Error>>>,
}

impl Output {
    fn note<T>(&self, done: io::Result<T>) -> io::Result<T> {
        done.inspect_err(|error| {
            let again = error
                .raw_os_error()
                .map_or_else(|| error.kind().into(), io::Error::from_raw_os_error);
            self.refused.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(again);
        })
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let done = self.file.write(bytes);
        self.note(done)
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = self.file.flush();
        self.note(done)
    }
}

impl Seek for Output {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let done = self.file.seek(to);
        self.note(done)
    }
}

/// Where the layout of a recording lies.
pub fn layout_beside(recording: &Path) -> PathBuf {
    recording.with_extension("layout.json")
}

/// Writes the layout at `path`; it is complete or as it was before.
fn write_layout(path: &Path) -> Result<(), FileError> {
    let names = std::iter::once(path.with_extension("part.json"))
        .chain((2..1000).map(|n| path.with_extension(format!("{n}.part.json"))));
    let (part, mut file) = Part::file(names).map_err(FileError::write(path))?;
    file.write_all(LAYOUT.as_bytes())
        .and_then(|()| files::sync(&file))
        .and_then(|()| std::fs::rename(&part.path, path))
        .map_err(|error| {
            // Nothing that anyone needs is in it.
            let _ = std::fs::remove_file(&part.path);
            FileError::write(path)(error)
        })
}

fn into_io(error: McapError, refused: &Mutex<Option<io::Error>>) -> io::Error {
    let noted = refused.lock().unwrap_or_else(PoisonError::into_inner).take();
    noted.unwrap_or_else(|| match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    })
}
