//! A run on disk: written so that a stop at any moment loses at most what came after the last
//! checkpoint, and read so that nothing damaged is ever trusted.
//!
//! ```text
//! policy.safetensors                      the policy alone
//! checkpoint/current.ckpt                 all of the run but its replay
//! checkpoint/previous.ckpt                the one before
//! checkpoint/replay-000000.episodes       episodes 0 to 999, one record each, appended
//! ```
//!
//! A `.ckpt` file is magic, version, length, CRC-32, the state in postcard, and the parts of it
//! that have got new fields since version 5 once more in JSON; where a stop left something undone,
//! that follows in JSON, too. A record is its episode's number in 4 bytes, its extent in 4 more,
//! the episode as little-endian `f32`, and a CRC-32 of the run's identity and of all of it (earlier
//! versions left the identity out). All records have the length of an episode of all steps: the
//! extent says in its lower 30 bits how many steps are missing, and in the upper two how the episode
//! ended. It is 0 where nothing ended it, as in all episodes of earlier versions. Records come first, so a state never counts an episode that is
//! not there.

use super::identity::run_id;
use super::state::{Pending, RunState};
use crate::config::TrainConfig;
use crate::env::{End, EnvSpec};
use crate::episode::Episode;
use crate::files::{self, FileError};
use crate::goal::{Achieved, Desired, Scene, TailSpec};
use crate::learner::state::{LearnerState, Trained};
use crate::policy::{Critic, PolicyInfo, RunId};
use crate::replay::Replay;
use serde::Deserialize;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// Name of the policy file in a run folder.
pub const POLICY_FILE: &str = "policy.safetensors";

/// Name of the folder of checkpoints in a run folder.
pub const CHECKPOINT_FOLDER: &str = "checkpoint";

const CURRENT: &str = "current.ckpt";
const PREVIOUS: &str = "previous.ckpt";
const MAGIC: [u8; 8] = *b"RHERCKPT";
const VERSION: u32 = 6;
/// The last version without JSON, which is still read.
const WITHOUT_JSON: u32 = 5;
const HEADER: usize = MAGIC.len() + 4 + 8 + 4;
const EPISODES_PER_FILE: u64 = 1000;

/// Largest `.ckpt` file in bytes.
const LARGEST: u64 = 1 << 33;

/// A checkpoint could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no checkpoint.
    #[error("there is no checkpoint in `{}`", folder.display())]
    Missing {
        /// Where one was expected.
        folder: PathBuf,
    },
    /// A file is not what was written.
    #[error("`{}` is damaged: {problem}; {last_good}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
        /// Which checkpoint is the last good one.
        last_good: String,
    },
    /// The checkpoint is of another version of this program.
    #[error("`{}` has version {found}, expected {expected}", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
        /// The version of this program.
        expected: u32,
    },
    /// The environment is not the one that the run was started with.
    #[error("the run was made in {expected}, but the environment is {found}")]
    Mismatch {
        /// Environment of the run.
        expected: String,
        /// Environment that was given.
        found: String,
    },
    /// The policy could not be written.
    #[error(transparent)]
    Policy(#[from] crate::policy::PolicyError),
}

/// The settings of the run in `folder`.
pub fn read_config(folder: &Path) -> Result<TrainConfig, CheckpointError> {
    read_state(folder).map(|(state, _)| state.config)
}

/// The settings that the environment of the run in `folder` was made with, in its own words.
pub fn read_variant(folder: &Path) -> Result<String, CheckpointError> {
    read_state(folder).map(|(state, _)| state.info.variant)
}

/// The first critic of the run in `folder`: what the learner expects of actions.
pub fn read_critic(folder: &Path) -> Result<Critic, CheckpointError> {
    let (state, mut learner) = read_state(folder)?;
    let Trained { shape, online, .. } = learner.critics.swap_remove(0);
    Ok(Critic::new(state.encoder, shape, online))
}

/// Writes a checkpoint of `state`, of `learner` and of the episodes that are not on disk yet, whose first is
/// number `saved_episodes`.
///
/// `folder` must be there: one that was moved away during the run is not made again.
pub(super) fn write<const N: usize>(
    folder: &Path,
    state: &RunState,
    learner: &LearnerState,
    replay: &Replay<N>,
    saved_episodes: u64,
) -> Result<(), CheckpointError> {
    let folder = folder.join(CHECKPOINT_FOLDER);
    match std::fs::create_dir(&folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            return Err(FileError::write(&folder)(error).into());
        }
        _ => {}
    }
    let run = run_id(&state.config, &state.info.variant);
    append_episodes(&folder, run, replay, saved_episodes)?;

    let current = folder.join(CURRENT);
    let unwritten = |error| FileError::write(&current)(error);
    let mut payload = postcard::to_stdvec(&(state, learner))
        .map_err(|error| unwritten(io::Error::other(error)))?;
    serde_json::to_writer(&mut payload, &(&state.config, &state.encoder))
        .map_err(|error| unwritten(error.into()))?;
    if state.pending != Pending::Nothing {
        serde_json::to_writer(&mut payload, &state.pending)
            .map_err(|error| unwritten(error.into()))?;
    }
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((payload.len() as u64).to_le_bytes());
    bytes.extend(crc32fast::hash(&payload).to_le_bytes());
    bytes.extend(payload);

    // The new state is whole on disk before the good one moves aside.
    let next = folder.join("next.ckpt");
    files::replace(&next, &bytes)?;
    if current.exists() {
        std::fs::rename(&current, folder.join(PREVIOUS)).map_err(FileError::write(&current))?;
    }
    std::fs::rename(&next, &current).map_err(FileError::write(&current))?;
    files::sync_folder(&folder)?;
    drop_old_files(&folder, saved_episodes, replay.capacity() as u64)
}

/// Reads the state of the run in `folder`, and its learner.
///
/// A damaged state is an error, not a reason to fall back silently; the one before is used only
/// where a stop fell between two renames.
pub(super) fn read_state(folder: &Path) -> Result<(RunState, LearnerState), CheckpointError> {
    let folder = folder.join(CHECKPOINT_FOLDER);
    let (current, previous) = (folder.join(CURRENT), folder.join(PREVIOUS));
    // A run that is being trained may rename them between two looks.
    match parse_state(&current) {
        Err(error) if is_absent(&error) => match parse_state(&previous) {
            Err(error) if is_absent(&error) => Err(CheckpointError::Missing { folder }),
            before => before,
        },
        now => now.map_err(|error| with_last_good(error, &previous)),
    }
}

fn is_absent(error: &CheckpointError) -> bool {
    use io::ErrorKind::{NotADirectory, NotFound};
    let CheckpointError::File(FileError { source, .. }) = error else { return false };
    matches!(source.kind(), NotFound | NotADirectory)
}

fn parse_state(path: &Path) -> Result<(RunState, LearnerState), CheckpointError> {
    let is_checkpoint = |start: &[u8]| start.starts_with(&MAGIC);
    let bytes = files::read_from(path, HEADER as u64, is_checkpoint, LARGEST)?;
    let damaged = |problem: String| CheckpointError::Damaged {
        path: path.to_owned(),
        problem,
        last_good: "there is no earlier good one".to_owned(),
    };
    let Some((header, payload)) = bytes.split_at_checked(HEADER) else {
        return Err(damaged(format!("{} bytes, shorter than its header", bytes.len())));
    };
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| header[at + i]));
    if !header.starts_with(&MAGIC) {
        return Err(damaged("it does not start like a checkpoint".to_owned()));
    }
    let (found, checksum) = (word(8), word(20));
    let length = u64::from(word(12)) | u64::from(word(16)) << 32;
    if ![WITHOUT_JSON, VERSION].contains(&found) {
        return Err(CheckpointError::Version { path: path.into(), found, expected: VERSION });
    }
    if payload.len() as u64 != length {
        let problem = format!("{} bytes of state, expected {length}", payload.len());
        return Err(damaged(problem));
    }
    let computed = crc32fast::hash(payload);
    if computed != checksum {
        let problem = format!("checksum {computed:08x}, expected {checksum:08x}");
        return Err(damaged(problem));
    }
    let ((mut state, learner), json): ((RunState, LearnerState), &[u8]) =
        postcard::take_from_bytes(payload).map_err(|error| damaged(error.to_string()))?;
    if found != WITHOUT_JSON {
        let not_json = |error: serde_json::Error| damaged(error.to_string());
        let mut json = serde_json::Deserializer::from_slice(json);
        (state.config, state.encoder) = Deserialize::deserialize(&mut json).map_err(not_json)?;
        if json.end().is_err() {
            state.pending = Deserialize::deserialize(&mut json).map_err(not_json)?;
            json.end().map_err(not_json)?;
        }
    }
    state.check().and_then(|()| state.check_learner(&learner)).map_err(damaged)?;
    Ok((state, learner))
}

fn with_last_good(error: CheckpointError, previous: &Path) -> CheckpointError {
    match (error, parse_state(previous)) {
        (CheckpointError::Damaged { path, problem, .. }, Ok((state, _))) => {
            let last_good = format!(
                "the last good one is `{}`, at environment step {}",
                previous.display(),
                state.env_steps
            );
            CheckpointError::Damaged { path, problem, last_good }
        }
        (error, _) => error,
    }
}

/// Reads the episodes that `state` counts and that fit in its replay.
pub(super) fn read_replay<const N: usize>(
    folder: &Path,
    state: &RunState,
    spec: &EnvSpec<N>,
) -> Result<Replay<N>, CheckpointError> {
    let name = |task: &str, variant: &str, objects, observation, action, tail: &TailSpec| {
        let variant = if variant.is_empty() { String::new() } else { format!(" ({variant})") };
        let tail = if tail.is_none() { String::new() } else { format!(" and goals of {tail}") };
        format!(
            "`{task}`{variant} with {objects} objects, observations of {observation} and actions \
             of {action}{tail}"
        )
    };
    let info = &state.info;
    let PolicyInfo { task, variant, objects, obs_dim, action_dim, .. } = info;
    let expected = name(task, variant, *objects, *obs_dim, *action_dim, state.encoder.tail());
    let EnvSpec { name: task, variant, obs_dim, action_dim, tolerances, .. } = spec;
    let found = name(task, variant, N, *obs_dim, *action_dim, &tolerances.tail);
    let same_goals = state.encoder.tail().means_the_same(&spec.tolerances.tail);
    if expected != found || !same_goals {
        return Err(CheckpointError::Mismatch { expected, found });
    }
    let run = run_id(&state.config, &state.info.variant);
    let folder = folder.join(CHECKPOINT_FOLDER);
    let layout = Layout {
        observation: spec.obs_dim,
        action: spec.action_dim,
        tail: spec.tolerances.tail.numbers(),
        steps: spec.episode_steps,
    };
    let mut open: Option<(u64, File)> = None;
    Replay::restore(spec, state.config.replay.capacity, state.episodes, |index| {
        let part = index / EPISODES_PER_FILE;
        let path = episodes_file(&folder, part);
        let file = match &mut open {
            Some((opened, file)) if *opened == part => file,
            slot => {
                let file = File::open(&path).map_err(FileError::read(&path))?;
                &mut slot.insert((part, file)).1
            }
        };
        let mut record = vec![0; layout.record::<N>()];
        file.seek(SeekFrom::Start((index % EPISODES_PER_FILE) * record.len() as u64))
            .and_then(|_| file.read_exact(&mut record))
            .map_err(|error| damaged_episode(&path, index, &error.to_string()))?;
        layout
            .decode(run, index, &record)
            .map_err(|problem| damaged_episode(&path, index, &problem))
    })
}

fn damaged_episode(path: &Path, index: u64, problem: &str) -> CheckpointError {
    CheckpointError::Damaged {
        path: path.to_owned(),
        problem: format!("episode {index}: {problem}"),
        last_good: "the state counts on it, so this run cannot be resumed; its policy is good"
            .to_owned(),
    }
}

fn append_episodes<const N: usize>(
    folder: &Path,
    run: RunId,
    replay: &Replay<N>,
    saved_episodes: u64,
) -> Result<(), CheckpointError> {
    let new = (replay.pushed() - saved_episodes).min(replay.episodes() as u64);
    let mut open: Option<(u64, PathBuf, File)> = None;
    let mut record = Vec::new();
    for (index, episode) in (replay.pushed() - new..).zip(replay.newest(new as usize)) {
        let part = index / EPISODES_PER_FILE;
        if open.as_ref().is_none_or(|(opened, ..)| *opened != part) {
            if let Some((_, path, file)) = open.take() {
                files::sync(&file).map_err(FileError::write(&path))?;
            }
            let path = episodes_file(folder, part);
            let file = OpenOptions::new().write(true).create(true).truncate(false).open(&path);
            open = Some((part, path.clone(), file.map_err(FileError::write(&path))?));
        }
        if let Some((_, path, file)) = &mut open {
            encode(run, index, &episode, [replay.room(), replay.tail()], &mut record);
            file.seek(SeekFrom::Start((index % EPISODES_PER_FILE) * record.len() as u64))
                .and_then(|_| file.write_all(&record))
                .map_err(FileError::write(path))?;
        }
    }
    match open {
        Some((_, path, file)) => Ok(files::sync(&file).map_err(FileError::write(&path))?),
        None => Ok(()),
    }
}

/// Deletes files of episodes that neither the current nor the previous state can need.
fn drop_old_files(
    folder: &Path,
    saved_episodes: u64,
    capacity: u64,
) -> Result<(), CheckpointError> {
    let oldest_needed = saved_episodes.saturating_sub(capacity) / EPISODES_PER_FILE;
    for part in (0..oldest_needed).rev() {
        let path = episodes_file(folder, part);
        match std::fs::remove_file(&path) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => break,
            Err(error) => return Err(FileError::write(&path)(error).into()),
        }
    }
    Ok(())
}

fn episodes_file(folder: &Path, part: u64) -> PathBuf {
    folder.join(format!("replay-{part:06}.episodes"))
}

/// Widths that fix the length of a record.
struct Layout {
    observation: usize,
    action: usize,
    /// Of one object.
    tail: usize,
    steps: usize,
}

impl Layout {
    fn record<const N: usize>(&self) -> usize {
        let frames = (self.steps + 1) * (self.observation + Scene::<N>::width(self.tail));
        8 + 4 * (Desired::<N>::width(self.tail) + frames + self.steps * self.action) + 4
    }

    fn decode<const N: usize>(
        &self,
        run: RunId,
        index: u64,
        record: &[u8],
    ) -> Result<Episode<N>, String> {
        let (body, expected) = record.split_at(record.len() - 4);
        let without_identity = crc32fast::hash(body);
        let computed = [checksum(run, body), without_identity];
        if computed.iter().all(|sum| expected != sum.to_le_bytes()) {
            return Err("checksum does not fit: it is damaged, or of another run".to_owned());
        }
        let (number, rest) = body.split_at(4);
        if number != (index as u32).to_le_bytes() {
            return Err("its place holds another episode".to_owned());
        }
        let (extent, floats) = rest.split_at(4);
        let extent = u32::from_le_bytes([0, 1, 2, 3].map(|i| extent[i]));
        let (end, missing) = (extent >> END, (extent & !(3 << END)) as usize);
        let end = ENDS.get(end as usize).copied().ok_or_else(|| format!("its end is {end}"))?;
        let steps = self.steps.checked_sub(missing).filter(|steps| *steps > 0);
        let steps =
            steps.ok_or_else(|| format!("{missing} of {} steps are missing", self.steps))?;
        let floats = floats.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        let floats: Vec<f32> = floats.collect();
        let (goal, floats) = floats.split_at(Desired::<N>::width(self.tail));
        let scene = Scene::<N>::width(self.tail);
        let (scenes, floats) = floats.split_at((self.steps + 1) * scene);
        let (observations, actions) = floats.split_at((self.steps + 1) * self.observation);
        let scenes = scenes.chunks_exact(scene).take(steps + 1);
        Ok(Episode {
            desired: Desired::read(goal, self.tail),
            observations: observations[..(steps + 1) * self.observation].to_vec(),
            achieved: scenes.map(|scene| Achieved(Scene::read(scene, self.tail))).collect(),
            actions: actions[..steps * self.action].to_vec(),
            end,
        })
    }
}

/// The checksum of an episode's record in the files of `run`.
fn checksum(run: RunId, body: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&run.0.to_le_bytes());
    hasher.update(body);
    hasher.finalize()
}

/// Where the end of an episode is in the extent of its record, in bits.
const END: u32 = 30;

/// How an episode ended, by what its record says.
const ENDS: [End; 3] = [End::Truncated, End::Solved, End::Failed];

/// Writes the record of an episode, as long as one with `room` steps, with `tail` numbers of an
/// object's tail.
fn encode<const N: usize>(
    run: RunId,
    index: u64,
    episode: &Episode<N>,
    [room, tail]: [usize; 2],
    record: &mut Vec<u8>,
) {
    let Episode { desired, observations, achieved, actions, end } = episode;
    let (steps, missing) = (episode.steps(), room - episode.steps());
    let end = match end {
        End::Truncated => 0,
        End::Solved => 1,
        End::Failed => 2,
    };
    record.clear();
    record.extend((index as u32).to_le_bytes());
    record.extend((missing as u32 | end << END).to_le_bytes());
    let scenes = achieved.iter().flat_map(|Achieved(scene)| scene.numbers(tail));
    let padding = |numbers: usize| std::iter::repeat_n(0.0, missing * numbers);
    let floats = desired
        .numbers(tail)
        .chain(scenes)
        .chain(padding(Scene::<N>::width(tail)))
        .chain(observations.iter().copied())
        .chain(padding(observations.len() / (steps + 1)))
        .chain(actions.iter().copied())
        .chain(padding(actions.len() / steps));
    record.extend(floats.flat_map(f32::to_le_bytes));
    record.extend(checksum(run, record).to_le_bytes());
}
