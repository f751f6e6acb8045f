//! Minari datasets, in its Parquet storage.

use super::columns::{Column, write_table};
use super::{Demonstration, ExportError, whole_folder, write};
use crate::About;
use serde_json::{Value, json};
use std::path::Path;

/// Of Minari, whose datasets look like this.
const VERSION: &str = "0.5.3";

/// Writes the folder of a dataset, which `minari.MinariDataset` opens at its folder `data`; its
/// identity is `rher/<TASK>-v0`.
///
/// Observations are those of a `GoalEnv`: `observation`, `achieved_goal` and `desired_goal`.
pub fn minari(
    path: &Path,
    about: &About,
    demonstrations: &[Demonstration],
) -> Result<(), ExportError> {
    whole_folder(path, |folder| {
        let data = folder.join("data");
        for (id, demonstration) in demonstrations.iter().enumerate() {
            let folder = data.join(id.to_string());
            write_table(&folder.join("part-0.parquet"), &episode(demonstration), None)?;
            let Demonstration { seed, steps, .. } = demonstration;
            let metadata = json!({ "id": id, "total_steps": steps, "seed": seed });
            write(&folder.join("metadata.json"), metadata.to_string().as_bytes())?;
        }
        let metadata = metadata(about, demonstrations);
        write(&data.join("metadata.json"), format!("{metadata:#}\n").as_bytes())
    })
}

/// One row for each frame; what belongs to actions is padded where there is none.
fn episode(demonstration: &Demonstration) -> Vec<(&'static str, Column)> {
    let [observation, goal, action] = demonstration.widths();
    let Demonstration {
        steps, observations, achieved, desired, actions, rewards, successes, ..
    } = demonstration;
    let frames = steps + 1;
    let mut actions = actions.clone();
    actions.resize(frames * action, 0.0);
    let mut rewards = rewards.clone();
    rewards.push(0.0);
    let truncations = (1..=frames).map(|step| step == *steps).collect();
    let observations = vec![
        ("observation", Column::Lists(observation, observations.clone())),
        ("achieved_goal", Column::Lists(goal, achieved.clone())),
        ("desired_goal", Column::Lists(goal, desired.repeat(frames))),
    ];
    vec![
        ("observations", Column::Group(observations)),
        ("actions", Column::Lists(action, actions)),
        ("rewards", Column::Numbers(rewards)),
        ("terminations", Column::Flags(vec![false; frames])),
        ("truncations", Column::Flags(truncations)),
        ("infos", Column::Group(vec![("is_success", Column::Flags(successes.clone()))])),
    ]
}

fn metadata(about: &About, demonstrations: &[Demonstration]) -> Value {
    let [observation, goal, action] = demonstrations[0].widths();
    let steps: usize = demonstrations.iter().map(|demonstration| demonstration.steps).sum();
    // As Python's `json` reads it.
    let infinite =
        |sign: &str, width| format!("[{}]", vec![format!("{sign}Infinity"); width].join(", "));
    let open = |width| {
        let (low, high) = (infinite("-", width), infinite("", width));
        format!(
            r#"{{"type": "Box", "dtype": "float32", "shape": [{width}], "low": {low}, "high": {high}}}"#
        )
    };
    let observation_space = format!(
        r#"{{"type": "Dict", "subspaces": {{"observation": {}, "achieved_goal": {}, "desired_goal": {}}}}}"#,
        open(observation),
        open(goal),
        open(goal)
    );
    let action_space = json!({
        "type": "Box",
        "dtype": "float32",
        "shape": [action],
        "low": vec![-1.0; action],
        "high": vec![1.0; action],
    });
    json!({
        "dataset_id": format!("rher/{}-v0", about.task),
        "total_episodes": demonstrations.len(),
        "total_steps": steps,
        "data_format": "parquet",
        "jpeg_encoding": false,
        "observation_space": observation_space,
        "action_space": action_space.to_string(),
        "minari_version": VERSION,
        "algorithm_name": "Relay Hindsight Experience Replay",
        "description": format!("`{}` with options {}, by rher {}", about.task, about.options, about.rher),
    })
}
