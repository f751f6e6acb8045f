//! Reading a recording back, one episode at a time.

use crate::info::{InfoError, RECORD, RecordingInfo};
use crate::message::{Action, Begin, Frame, Topic};
use crate::records::Records;
use mcap::records::Record;
use mcap::{MAGIC, McapError};
use rher_core::explore::{ActionLog, Decision};
use rher_core::files::FileError;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// A recording that is being read: an iterator over its episodes, which holds one of them at a time.
///
/// There is at least one episode, or an error that says why not. After an error nothing follows.
pub struct Recording {
    /// The description of the recording.
    pub info: RecordingInfo,
    path: PathBuf,
    records: Records,
    topics: HashMap<u16, Topic>,
    /// Messages of the episode that was begun.
    messages: Vec<Sent>,
    episodes: usize,
    /// Whether the file ends in the middle.
    cut_off: bool,
    finished: bool,
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
    Info {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: InfoError,
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
    /// Opens a file.
    ///
    /// A recording that is not finished (`.part.mcap`: it is being written, or its writer was
    /// killed) has the episodes that are whole. Any other file has to be complete.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is no recording of this program, or is cut off.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let mut recording = Self::open_as_it_is(path)?;
        if recording.cut_off && !is_unfinished(path) {
            let whole = recording.by_ref().take_while(Result::is_ok).count();
            return Err(ReadError::CutOff { path: path.to_owned(), whole });
        }
        Ok(recording)
    }

    fn open_as_it_is(path: &Path) -> Result<Self, ReadError> {
        let failed = FileError::read(path);
        let mut file = File::open(path).map_err(&failed)?;
        let length = file.metadata().map_err(&failed)?.len();
        let magic = |file: &mut File, from| -> io::Result<bool> {
            file.seek(from)?;
            let mut bytes = [0; MAGIC.len()];
            match file.read_exact(&mut bytes) {
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
                read => read.map(|()| bytes == MAGIC),
            }
        };
        if !magic(&mut file, SeekFrom::Start(0)).map_err(&failed)? {
            return Err(ReadError::NotMcap { path: path.to_owned() });
        }
        let last = length.saturating_sub(MAGIC.len() as u64);
        let ends = last >= MAGIC.len() as u64
            && magic(&mut file, SeekFrom::Start(last)).map_err(&failed)?;
        // Whoever copies a recording may put its description behind its messages.
        let start = |file: File, skip_chunks| -> Result<Records, ReadError> {
            let mut file = BufReader::new(file);
            file.seek(SeekFrom::Start(0)).map_err(&failed)?;
            Ok(Records::new(file, length, skip_chunks))
        };
        let mut records = start(file.try_clone().map_err(&failed)?, true)?;
        let mut info = None;
        let found = loop {
            let found = records.next(|record| {
                if let Record::Metadata(metadata) = record
                    && metadata.name == RECORD
                {
                    info = Some(RecordingInfo::from_record(&metadata.metadata));
                }
            });
            match found {
                Ok(true) if info.is_none() => {}
                end => break end,
            }
        };
        let path = path.to_owned();
        let Some(info) = info else {
            return Err(match found {
                Err(McapError::Io(source)) => FileError::read(&path)(source).into(),
                _ if !ends => ReadError::CutOff { path, whole: 0 },
                Err(error) => ReadError::Damaged { path, problem: error.to_string() },
                Ok(_) => ReadError::Foreign { path },
            });
        };
        let info = match info {
            Ok(info) => info,
            Err(source) => return Err(ReadError::Info { path, source }),
        };
        Ok(Self {
            info,
            records: start(file, false)?,
            path,
            topics: HashMap::new(),
            messages: Vec::new(),
            episodes: 0,
            cut_off: !ends,
            finished: false,
        })
    }

    /// Whether the file ends in the middle of an episode, which is left out.
    pub fn is_cut_off(&self) -> bool {
        self.cut_off
    }

    /// The messages of the next episode; none at the end.
    fn next_messages(&mut self) -> Result<Vec<Sent>, McapError> {
        loop {
            let mut sent = None;
            let topics = &mut self.topics;
            let more = self.records.next(|record| match record {
                Record::Channel(channel) => {
                    let topic = Topic::ALL.into_iter().find(|topic| topic.name() == channel.topic);
                    topics.extend(topic.map(|topic| (channel.id, topic)));
                }
                Record::Message { header, data } => {
                    // Whoever copies a recording may have added topics.
                    sent = topics.get(&header.channel_id).map(|&topic| Sent {
                        time: header.log_time,
                        topic,
                        bytes: data.into_owned(),
                    });
                }
                _ => {}
            })?;
            if !more {
                return Ok(std::mem::take(&mut self.messages));
            }
            let Some(sent) = sent else { continue };
            let begins = sent.topic == Topic::Begin;
            if begins && !self.messages.is_empty() {
                return Ok(std::mem::replace(&mut self.messages, vec![sent]));
            }
            // What is sent before the first episode is no part of any.
            if begins || !self.messages.is_empty() {
                self.messages.push(sent);
            }
        }
    }

    fn read_next(&mut self) -> Result<Option<Recorded>, ReadError> {
        let next = self.next_messages();
        let path = || self.path.clone();
        let damaged = |problem| ReadError::Damaged { path: path(), problem };
        let messages = match next {
            Ok(messages) => messages,
            // The last episode may be whole although the record after it is not.
            Err(error) if self.cut_off && !matches!(error, McapError::Io(_)) => {
                self.finished = true;
                std::mem::take(&mut self.messages)
            }
            Err(McapError::Io(source)) => return Err(FileError::read(&self.path)(source).into()),
            Err(error) => return Err(damaged(error.to_string())),
        };
        if messages.is_empty() {
            self.finished = true;
        }
        let last = self.finished || self.messages.is_empty();
        let episode = if messages.is_empty() {
            None
        } else {
            match Recorded::of(messages, self.info.subtasks) {
                Ok(episode) => Some(episode),
                Err(_) if self.cut_off && last => None,
                Err(problem) => return Err(damaged(problem)),
            }
        };
        match episode {
            Some(episode) => {
                self.episodes += 1;
                Ok(Some(episode))
            }
            None if self.episodes > 0 => Ok(None),
            None if self.cut_off => Err(ReadError::CutOff { path: path(), whole: 0 }),
            None => Err(ReadError::Empty { path: path() }),
        }
    }
}

impl Iterator for Recording {
    type Item = Result<Recorded, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.finished {
            return None;
        }
        let next = self.read_next().transpose();
        self.finished |= !matches!(next, Some(Ok(_)));
        next
    }
}

/// Whether the name says that the recording is not finished.
pub(crate) fn is_unfinished(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(".part.mcap"))
}

impl Recorded {
    /// An episode of its messages, or what is wrong with them; its task has this many sub-tasks.
    fn of(messages: Vec<Sent>, subtasks: usize) -> Result<Self, String> {
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
            (Topic::Transforms, begin.steps.saturating_add(1)),
            (Topic::Scene, 1),
            (Topic::Begin, 1),
            (Topic::Frame, begin.steps.saturating_add(1)),
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
        check_widths(&begin, &frames, &actions, subtasks)?;
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

/// Whether every step of an episode has as many numbers as the others, and as its task asks for.
fn check_widths(
    begin: &Begin,
    frames: &[Frame],
    actions: &[Action],
    subtasks: usize,
) -> Result<(), String> {
    let objects = begin.targets.len();
    let fits = |what: &str, step: usize, found: usize, expected: usize| {
        if found == expected {
            return Ok(());
        }
        let episode = begin.episode;
        Err(format!("episode {episode}, step {step}: {found} {what}, expected {expected}"))
    };
    if begin.steps == 0 || objects == 0 || !(1..=2 * objects).contains(&subtasks) {
        let (episode, steps) = (begin.episode, begin.steps);
        return Err(format!(
            "episode {episode} has {steps} steps and {objects} objects in {subtasks} sub-tasks"
        ));
    }
    let [observation, action] =
        [frames[0].observation.len(), actions.first().map_or(0, |first| first.action.len())];
    for (step, frame) in frames.iter().enumerate() {
        fits("numbers in the observation", step, frame.observation.len(), observation)?;
        fits("objects", step, frame.objects.len(), objects)?;
        fits("rewards", step, usize::from(frame.reward.is_some()), usize::from(step > 0))?;
    }
    for (step, taken) in actions.iter().enumerate() {
        fits("numbers in the action", step, taken.action.len(), action.max(1))?;
    }
    Ok(())
}

fn parse<'a, T: serde::Deserialize<'a>>(sent: &'a Sent) -> Result<T, serde_json::Error> {
    serde_json::from_slice(&sent.bytes)
}
