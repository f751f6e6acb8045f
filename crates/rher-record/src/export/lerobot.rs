//! LeRobot datasets, version 3.0, without pictures.

use super::columns::{Column, write_table};
use super::{Demonstration, ExportError, whole_folder, write};
use crate::About;
use rher_envs::STEP_SECONDS;
use serde_json::{Map, Value, json};
use std::path::Path;

const VERSION: &str = "v3.0";
const FRAMES_PER_SECOND: u32 = (1.0 / STEP_SECONDS + 0.5) as u32;
const DATA: &str = "data/chunk-000/file-000.parquet";

/// Writes the folder of a dataset, which `LeRobotDataset` opens as its `root`.
///
/// The goal is `observation.environment_state`: with it policies learn without pictures.
pub fn lerobot(
    path: &Path,
    about: &About,
    demonstrations: &[Demonstration],
) -> Result<(), ExportError> {
    let features = features(demonstrations);
    whole_folder(path, |folder| {
        let columns: Vec<_> = features.into_iter().map(Feature::split).collect();
        let (columns, described): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
        let of = |part: fn(&Described) -> &Value| -> Map<String, Value> {
            described.iter().map(|it| (it.name.to_owned(), part(it).clone())).collect()
        };
        write_table(&folder.join(DATA), &columns, None)?;
        let (names, pandas) = tasks(about);
        write_table(&folder.join("meta/tasks.parquet"), &names, Some(("pandas", pandas)))?;
        let episodes = episodes(about, demonstrations);
        write_table(&folder.join("meta/episodes/chunk-000/file-000.parquet"), &episodes, None)?;
        let stats = Value::Object(of(|it| &it.stats));
        write(&folder.join("meta/stats.json"), format!("{stats:#}\n").as_bytes())?;
        let frames: usize = demonstrations.iter().map(|demonstration| demonstration.steps).sum();
        let info = json!({
            "codebase_version": VERSION,
            "robot_type": "fetch",
            "total_episodes": demonstrations.len(),
            "total_frames": frames,
            "total_tasks": 1,
            "chunks_size": 1000,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": FRAMES_PER_SECOND,
            "splits": { "train": format!("0:{}", demonstrations.len()) },
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": null,
            "features": of(|it| &it.feature),
        });
        write(&folder.join("meta/info.json"), format!("{info:#}\n").as_bytes())
    })
}

/// A column of the data, a row for each action.
struct Feature {
    name: &'static str,
    kind: &'static str,
    column: Column,
}

/// What is told of a column besides its rows.
struct Described {
    name: &'static str,
    feature: Value,
    stats: Value,
}

impl Feature {
    fn split(self) -> ((&'static str, Column), Described) {
        let Self { name, kind, column } = self;
        let (width, values) = match &column {
            Column::Lists(width, values) => (*width, doubles(values)),
            Column::Numbers(values) => (1, doubles(values)),
            Column::Integers(values) => (1, values.iter().copied().map(f64::from).collect()),
            Column::Flags(values) => {
                (1, values.iter().map(|flag| f64::from(u8::from(*flag))).collect())
            }
            Column::Texts(_) | Column::TextLists(_) | Column::Group(_) => (1, Vec::new()),
        };
        let feature = json!({ "dtype": kind, "shape": [width], "names": null });
        ((name, column), Described { name, feature, stats: stats(width, &values) })
    }
}

fn doubles(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| f64::from(*value)).collect()
}

fn features(demonstrations: &[Demonstration]) -> Vec<Feature> {
    let [observation, goal, action] = demonstrations[0].widths();
    let rows = |row: &dyn Fn(&Demonstration) -> Vec<f32>| -> Vec<f32> {
        demonstrations.iter().flat_map(row).collect()
    };
    let steps = || demonstrations.iter().map(|demonstration| demonstration.steps);
    let in_episode = || steps().flat_map(|steps| 0..steps);
    let episode = steps().enumerate().flat_map(|(index, steps)| vec![index as u32; steps]);
    let total = in_episode().count();
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
        ("index", "int64", Column::Integers((0..total as u32).collect())),
        ("task_index", "int64", Column::Integers(vec![0; total])),
    ]
    .map(|(name, kind, column)| Feature { name, kind, column })
    .into()
}

/// Of every number of a row, over all rows.
fn stats(width: usize, values: &[f64]) -> Value {
    let rows = values.len() / width;
    let columns: Vec<Vec<f64>> = (0..width)
        .map(|column| {
            let mut numbers: Vec<f64> =
                values.iter().skip(column).step_by(width).copied().collect();
            numbers.sort_by(f64::total_cmp);
            numbers
        })
        .collect();
    let mean = |numbers: &[f64]| numbers.iter().sum::<f64>() / rows as f64;
    let deviation = |numbers: &[f64]| {
        let mean = mean(numbers);
        (numbers.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / rows as f64).sqrt()
    };
    let quantile = |numbers: &[f64], share: f64| {
        let place = share * (rows - 1) as f64;
        let (low, part) = (numbers[place as usize], place.fract());
        low + part * (numbers[place.ceil() as usize] - low)
    };
    let of = |what: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
        columns.iter().map(|numbers| what(numbers)).collect()
    };
    json!({
        "min": of(&|numbers| numbers[0]),
        "max": of(&|numbers| numbers[rows - 1]),
        "mean": of(&mean),
        "std": of(&deviation),
        "count": [rows],
        "q01": of(&|numbers| quantile(numbers, 0.01)),
        "q10": of(&|numbers| quantile(numbers, 0.1)),
        "q50": of(&|numbers| quantile(numbers, 0.5)),
        "q90": of(&|numbers| quantile(numbers, 0.9)),
        "q99": of(&|numbers| quantile(numbers, 0.99)),
    })
}

/// What the robot is told to do.
fn instruction(about: &About) -> String {
    about.task.replace('-', " ")
}

/// The table of tasks, whose rows are named by the instruction: pandas is told so in a note.
fn tasks(about: &About) -> (Vec<(&'static str, Column)>, String) {
    const NAME: &str = "__index_level_0__";
    let columns = vec![
        ("task_index", Column::Integers(vec![0])),
        (NAME, Column::Texts(vec![instruction(about)])),
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

fn episodes(about: &About, demonstrations: &[Demonstration]) -> Vec<(&'static str, Column)> {
    let count = demonstrations.len();
    let lengths: Vec<u32> = demonstrations.iter().map(|it| it.steps as u32).collect();
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
        ("tasks", Column::TextLists(vec![instruction(about); count])),
        ("length", Column::Integers(lengths)),
        ("data/chunk_index", zeros()),
        ("data/file_index", zeros()),
        ("dataset_from_index", Column::Integers(begins)),
        ("dataset_to_index", Column::Integers(ends)),
        ("meta/episodes/chunk_index", zeros()),
        ("meta/episodes/file_index", zeros()),
    ]
}
