//! Reading a recording back.

use crate::about::{About, AboutError, RECORD};
use crate::message::{Action, Begin, Frame, Topic};
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};
use rher_core::explore::{ActionLog, Decision};
use rher_core::files::FileError;
use std::collections::HashMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Longest record or chunk that is read, in bytes: the lengths in a damaged file ask for memory
/// that nobody has. Those that are written are a hundredth of it.
const LONGEST_RECORD: usize = 1 << 28;

/// A recording, read back.
#[derive(Clone, Debug)]
pub struct Recording {
    /// What it says of itself.
    pub about: About,
    /// At least one.
    pub episodes: Vec<Recorded>,
}

/// An episode of a recording.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// What it can be played again from.
    pub script: ActionLog,
    /// Where it begins.
    pub begin: Begin,
    /// What was reached: one more than there are actions.
    pub frames: Vec<Frame>,
    /// What was done.
    pub actions: Vec<Action>,
    /// Every message of it, in the order of the file.
    pub messages: Vec<Sent>,
}

/// A message as it lies in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Sent {
    /// Nanoseconds.
    pub time: u64,
    /// Where it was sent.
    pub topic: Topic,
    /// What was sent.
    pub bytes: Vec<u8>,
}

/// A file cannot be read as a recording.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// It does not begin like an MCAP file.
    #[error("`{}` is not an MCAP file", path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
    },
    /// It ends too early.
    #[error("`{}` is cut off after {whole} whole episodes", path.display())]
    CutOff {
        /// The file.
        path: PathBuf,
        /// Episodes that are complete.
        whole: usize,
    },
    /// It is an MCAP file of something else.
    #[error("`{}` was not recorded by this program", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// It does not describe itself as this version of the program does.
    #[error("`{}` cannot be understood", path.display())]
    About {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: AboutError,
    },
    /// It has been changed since it was written.
    #[error("`{}` is damaged: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// There is no episode in it.
    #[error("there is no episode in `{}`", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
}

impl Recording {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let path_of = || path.to_owned();
        let bytes = std::fs::read(path).map_err(FileError::read(path))?;
        if !bytes.starts_with(MAGIC) {
            return Err(ReadError::NotMcap { path: path_of() });
        }
        let mut contents = Contents::default();
        let read = contents.read(&bytes);
        if !bytes.ends_with(MAGIC) || bytes.len() < 2 * MAGIC.len() {
            return Err(ReadError::CutOff { path: path_of(), whole: contents.whole() });
        }
        read.map_err(|error| ReadError::Damaged { path: path_of(), problem: error.to_string() })?;
        let about = contents.about.ok_or_else(|| ReadError::Foreign { path: path_of() })?;
        let about = about.map_err(|source| ReadError::About { path: path_of(), source })?;
        let episodes = contents
            .episodes
            .into_iter()
            .map(Recorded::of)
            .collect::<Result<Vec<_>, _>>()
            .map_err(|problem| ReadError::Damaged { path: path_of(), problem })?;
        if episodes.is_empty() {
            return Err(ReadError::Empty { path: path_of() });
        }
        Ok(Self { about, episodes })
    }
}

/// What was found in a file so far.
#[derive(Default)]
struct Contents {
    about: Option<Result<About, AboutError>>,
    topics: HashMap<u16, Topic>,
    episodes: Vec<Vec<Sent>>,
}

impl Contents {
    fn read(&mut self, mut bytes: &[u8]) -> Result<(), McapError> {
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_validate_chunk_crcs(true)
            .with_record_length_limit(LONGEST_RECORD);
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let read = bytes.read(reader.insert(wanted))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    self.take(mcap::parse_record(opcode, data)?);
                }
            }
        }
        Ok(())
    }

    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Metadata(metadata) if metadata.name == RECORD => {
                self.about = Some(About::from_record(&metadata.metadata));
            }
            Record::Channel(channel) => {
                let topic = Topic::ALL.into_iter().find(|topic| topic.name() == channel.topic);
                self.topics.extend(topic.map(|topic| (channel.id, topic)));
            }
            Record::Message { header, data } => {
                // Whoever copies a recording may have added topics.
                let Some(&topic) = self.topics.get(&header.channel_id) else { return };
                let sent = Sent { time: header.log_time, topic, bytes: data.into_owned() };
                if topic == Topic::Begin {
                    self.episodes.push(Vec::new());
                }
                if let Some(episode) = self.episodes.last_mut() {
                    episode.push(sent);
                }
            }
            _ => {}
        }
    }

    fn whole(&self) -> usize {
        self.episodes.iter().filter(|messages| Recorded::of((*messages).clone()).is_ok()).count()
    }
}

impl Recorded {
    /// An episode of its messages, or what is wrong with them.
    fn of(messages: Vec<Sent>) -> Result<Self, String> {
        let of_topic = |topic| messages.iter().filter(move |sent| sent.topic == topic);
        let unreadable = |sent: &Sent, error| {
            format!("a message on `{}` at {} ns: {error}", sent.topic.name(), sent.time)
        };
        let begin: Begin = of_topic(Topic::Begin)
            .next()
            .map(|sent| parse(sent).map_err(|error| unreadable(sent, error)))
            .ok_or("an episode without a beginning")??;
        let actions = of_topic(Topic::Action)
            .map(|sent| parse::<Action>(sent).map_err(|error| unreadable(sent, error)))
            .collect::<Result<Vec<_>, _>>()?;
        let frames = of_topic(Topic::Frame)
            .map(|sent| parse::<Frame>(sent).map_err(|error| unreadable(sent, error)))
            .collect::<Result<Vec<_>, _>>()?;
        let expected = [
            (Topic::Transforms, begin.steps + 1),
            (Topic::Scene, 1),
            (Topic::Begin, 1),
            (Topic::Frame, begin.steps + 1),
            (Topic::Action, begin.steps),
        ];
        for (topic, expected) in expected {
            let found = of_topic(topic).count();
            if found != expected {
                let (episode, topic) = (begin.episode, topic.name());
                return Err(format!(
                    "episode {episode} has {found} messages on `{topic}`, expected {expected}"
                ));
            }
        }
        let script = ActionLog {
            number: begin.episode,
            seed: begin.seed,
            actions: actions.iter().flat_map(|action| action.action.clone()).collect(),
            decisions: actions
                .iter()
                .map(|&Action { decider, subtask, q, .. }| Decision {
                    source: decider,
                    subtask: subtask.saturating_sub(1),
                    value: q,
                })
                .collect(),
        };
        Ok(Self { script, begin, frames, actions, messages })
    }

    /// What was reached in the end.
    pub fn end(&self) -> &Frame {
        &self.frames[self.frames.len() - 1]
    }
}

fn parse<'a, T: serde::Deserialize<'a>>(sent: &'a Sent) -> Result<T, serde_json::Error> {
    serde_json::from_slice(&sent.bytes)
}
