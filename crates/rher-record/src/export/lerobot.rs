//! LeRobot datasets, version 3.0, without pictures.

use super::columns::{Column, Named, Table, write_table};
use super::demonstration::Demonstration;
use super::error::{ExportError, write};
use super::stats::Stats;
use crate::RecordingInfo;
use rher_envs::STEP_SECONDS;
use serde_json::{Map, Value, json};
use std::path::Path;

const VERSION: &str = "v3.0";
const FRAMES_PER_SECOND: u32 = (1.0 / STEP_SECONDS + 0.5) as u32;
const DATA: &str = "data/chunk-000/file-000.parquet";

/// Frames that are collected before they are written.
const ROW_GROUP: usize = 4096;

/// A dataset that `LeRobotDataset` opens with its folder as `root`, while it is written.
///
/// The goal is `observation.environment_state`: with it policies learn without pictures.
pub(super) struct Lerobot {
    info: RecordingInfo,
    /// Frames of each episode.
    lengths: Vec<u32>,
    /// Episodes that are not in the table yet.
    waiting: Vec<Demonstration>,
    written: Option<Box<Written>>,
}

/// What is in the table of frames.
struct Written {
    table: Table,
    episodes: usize,
    frames: usize,
    features: Vec<Feature>,
}

/// A column of the table.
struct Feature {
    name: &'static str,
    kind: &'static str,
    width: usize,
    stats: Stats,
}

impl Lerobot {
    pub(super) fn new(info: &RecordingInfo) -> Self {
        let (lengths, waiting) = (Vec::new(), Vec::new());
        Self { info: info.clone(), lengths, waiting, written: None }
    }

    pub(super) fn add(
        &mut self,
        folder: &Path,
        demonstration: &Demonstration,
    ) -> Result<(), ExportError> {
        self.lengths.push(demonstration.steps as u32);
        self.waiting.push(demonstration.clone());
        let frames: usize = self.waiting.iter().map(|waiting| waiting.steps).sum();
        if frames < ROW_GROUP { Ok(()) } else { self.write_waiting(folder) }
    }

    /// Moves the episodes that wait to the table.
    fn write_waiting(&mut self, folder: &Path) -> Result<(), ExportError> {
        let waiting = std::mem::take(&mut self.waiting);
        let [episodes, frames] =
            self.written.as_ref().map_or([0; 2], |written| [written.episodes, written.frames]);
        let columns = columns(&waiting, episodes, frames);
        let kinds = columns.iter().map(|(name, kind, column)| (*name, *kind, numbers(column)));
        let values: Vec<_> = kinds.collect();
        let columns: Vec<Named> =
            columns.into_iter().map(|(name, _, column)| (name, column)).collect();
        let written = match &mut self.written {
            Some(written) => written,
            none => {
                let table = Table::create(&folder.join(DATA), &columns, None)?;
                let features = values.iter().map(|&(name, kind, (width, _))| Feature {
                    name,
                    kind,
                    width,
                    stats: Stats::new(width),
                });
                let features = features.collect();
                none.insert(Box::new(Written { table, episodes, frames, features }))
            }
        };
        written.table.add(&columns)?;
        for (feature, (_, _, (_, values))) in written.features.iter_mut().zip(&values) {
            feature.stats.add(values);
        }
        written.episodes += waiting.len();
        written.frames += waiting.iter().map(|waiting| waiting.steps).sum::<usize>();
        Ok(())
    }

    pub(super) fn finish(mut self, folder: &Path) -> Result<(), ExportError> {
        if !self.waiting.is_empty() {
            self.write_waiting(folder)?;
        }
        let Self { info, lengths, written, .. } = self;
        let Some(written) = written else { return Ok(()) };
        let Written { table, episodes: count, frames, features } = *written;
        table.finish()?;
        let (names, pandas) = tasks(&info);
        write_table(&folder.join("meta/tasks.parquet"), &names, Some(("pandas", pandas)))?;
        let episodes = episodes(&info, lengths);
        write_table(&folder.join("meta/episodes/chunk-000/file-000.parquet"), &episodes, None)?;
        let of = |part: fn(&Feature) -> Value| -> Map<String, Value> {
            features.iter().map(|feature| (feature.name.to_owned(), part(feature))).collect()
        };
        let stats = Value::Object(of(|feature| feature.stats.to_json()));
        write(&folder.join("meta/stats.json"), format!("{stats:#}\n").as_bytes())?;
        let described =
            of(|feature| json!({ "dtype": feature.kind, "shape": [feature.width], "names": null }));
        let info = json!({
            "codebase_version": VERSION,
            "robot_type": "fetch",
            "total_episodes": count,
            "total_frames": frames,
            "total_tasks": 1,
            "chunks_size": 1000,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": FRAMES_PER_SECOND,
            "splits": { "train": format!("0:{count}") },
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": null,
            "features": described,
        });
        write(&folder.join("meta/info.json"), format!("{info:#}\n").as_bytes())
    }
}

/// How wide a column is, and its numbers row by row.
fn numbers(column: &Column) -> (usize, Vec<f64>) {
    match column {
        Column::Lists(width, values) => (*width, doubles(values)),
        Column::Numbers(values) => (1, doubles(values)),
        Column::Integers(values) => (1, values.iter().copied().map(f64::from).collect()),
        Column::Flags(values) => {
            (1, values.iter().map(|flag| f64::from(u8::from(*flag))).collect())
        }
        _ => (1, Vec::new()),
    }
}

fn doubles(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| f64::from(*value)).collect()
}

/// The columns of these episodes, after so many episodes and frames.
fn columns(
    demonstrations: &[Demonstration],
    episodes_before: usize,
    frames_before: usize,
) -> [(&'static str, &'static str, Column); 11] {
    let [observation, goal, action] = demonstrations[0].widths();
    let rows = |row: &dyn Fn(&Demonstration) -> Vec<f32>| -> Vec<f32> {
        demonstrations.iter().flat_map(row).collect()
    };
    let steps = || demonstrations.iter().map(|demonstration| demonstration.steps);
    let in_episode = || steps().flat_map(|steps| 0..steps);
    let episode = (episodes_before..).zip(steps());
    let episode = episode.flat_map(|(index, steps)| vec![index as u32; steps]);
    let total = in_episode().count();
    let index = frames_before..frames_before + total;
    let done = steps().flat_map(|steps| (1..=steps).map(move |step| step == steps));
    let successes = demonstrations.iter().flat_map(|it| it.successes[1..].to_vec());
    let seen = rows(&|it| it.observations[..it.steps * observation].to_vec());
    let wanted = rows(&|it| it.desired.repeat(it.steps));
    let time = in_episode().map(|step| step as f32 / FRAMES_PER_SECOND as f32);
    [
        ("observation.state", "float32", Column::Lists(observation, seen)),
        ("observation.environment_state", "float32", Column::Lists(goal, wanted)),
        ("action", "float32", Column::Lists(action, rows(&|it| it.actions.clone()))),
        ("next.reward", "float32", Column::Numbers(rows(&|it| it.rewards.clone()))),
        ("next.done", "bool", Column::Flags(done.collect())),
        ("next.success", "bool", Column::Flags(successes.collect())),
        ("timestamp", "float32", Column::Numbers(time.collect())),
        ("frame_index", "int64", Column::Integers(in_episode().map(|step| step as u32).collect())),
        ("episode_index", "int64", Column::Integers(episode.collect())),
        ("index", "int64", Column::Integers(index.map(|index| index as u32).collect())),
        ("task_index", "int64", Column::Integers(vec![0; total])),
    ]
}

/// The instruction that the robot follows.
fn instruction(info: &RecordingInfo) -> String {
    info.task.replace('-', " ")
}

/// The table of tasks, whose rows are named by the instruction; a note for pandas says so.
fn tasks(info: &RecordingInfo) -> (Vec<Named>, String) {
    const NAME: &str = "__index_level_0__";
    let columns = vec![
        ("task_index", Column::Integers(vec![0])),
        (NAME, Column::Texts(vec![instruction(info)])),
    ];
    let column = |name: Value, field, pandas, numpy| {
        json!({
            "name": name,
            "field_name": field,
            "pandas_type": pandas,
            "numpy_type": numpy,
            "metadata": null,
        })
    };
    let note = json!({
        "index_columns": [NAME],
        "column_indexes": [],
        "columns": [
            column("task_index".into(), "task_index", "int64", "int64"),
            column(Value::Null, NAME, "unicode", "object"),
        ],
        "pandas_version": "2.0.0",
    });
    (columns, note.to_string())
}

fn episodes(info: &RecordingInfo, lengths: Vec<u32>) -> Vec<Named> {
    let count = lengths.len();
    let ends: Vec<u32> = lengths
        .iter()
        .scan(0, |sum, length| {
            *sum += length;
            Some(*sum)
        })
        .collect();
    let begins = ends.iter().zip(&lengths).map(|(end, length)| end - length).collect();
    let zeros = || Column::Integers(vec![0; count]);
    vec![
        ("episode_index", Column::Integers((0..count as u32).collect())),
        ("tasks", Column::TextLists(vec![instruction(info); count])),
        ("length", Column::Integers(lengths)),
        ("data/chunk_index", zeros()),
        ("data/file_index", zeros()),
        ("dataset_from_index", Column::Integers(begins)),
        ("dataset_to_index", Column::Integers(ends)),
        ("meta/episodes/chunk_index", zeros()),
        ("meta/episodes/file_index", zeros()),
    ]
}
