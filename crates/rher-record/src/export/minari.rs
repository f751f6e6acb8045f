//! Minari datasets, in its Parquet storage.

use super::columns::{Column, write_table};
use super::demonstration::Demonstration;
use super::error::{ExportError, unwritable, write};
use crate::RecordingInfo;
use rher_envs::{Options, Task};
use serde_json::{Map, Value, json};
use std::fmt;
use std::io;
use std::path::Path;
use std::str::FromStr;

/// Of Minari, whose datasets look like this.
const VERSION: &str = "0.5.3";

/// How far numbers of an observation may be from 0, as in the Gymnasium environments.
const FAR: f64 = 100.0;

/// The identity of a Minari dataset: `NAMESPACE/NAME-vN`, of which the namespace may be left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatasetId(String);

impl DatasetId {
    /// The identity of a dataset that has no other: `rher/<TASK>-v0`.
    pub fn of_task(task: &str) -> Self {
        Self(format!("rher/{task}-v0"))
    }
}

impl fmt::Display for DatasetId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A text is no identity of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected NAMESPACE/NAME-vN of letters, digits, `-` and `_`, such as rher/push-v1")]
pub struct InvalidDatasetId;

impl FromStr for DatasetId {
    type Err = InvalidDatasetId;

    fn from_str(text: &str) -> Result<Self, InvalidDatasetId> {
        let (namespace, name) = text.rsplit_once('/').unwrap_or(("namespace", text));
        let (name, version) = name.rsplit_once("-v").ok_or(InvalidDatasetId)?;
        let word = |text: &str| {
            !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c))
        };
        let namespace = namespace.len() > 1 && namespace.split('/').all(word);
        let version = !version.is_empty() && version.bytes().all(|byte| byte.is_ascii_digit());
        if namespace && version && word(name) {
            Ok(Self(text.to_owned()))
        } else {
            Err(InvalidDatasetId)
        }
    }
}

/// What is known of a dataset while its episodes are written, each to files of its own.
pub(super) struct Minari {
    id: DatasetId,
    info: RecordingInfo,
    episodes: usize,
    steps: usize,
    longest: usize,
}

impl Minari {
    pub(super) fn new(id: DatasetId, info: RecordingInfo) -> Self {
        Self { id, info, episodes: 0, steps: 0, longest: 0 }
    }

    pub(super) fn add(
        &mut self,
        folder: &Path,
        demonstration: &Demonstration,
    ) -> Result<(), ExportError> {
        let &Demonstration { seed, steps, .. } = demonstration;
        let id = self.episodes;
        let folder = folder.join("data").join(id.to_string());
        write_table(&folder.join("part-0.parquet"), &episode(demonstration), None)?;
        let metadata = json!({ "id": id, "total_steps": steps, "seed": seed });
        write(&folder.join("metadata.json"), metadata.to_string().as_bytes())?;
        self.episodes += 1;
        self.steps += steps;
        self.longest = self.longest.max(steps);
        Ok(())
    }

    /// Observations are those of a `GoalEnv`: `observation`, `achieved_goal` and `desired_goal`.
    pub(super) fn finish(self, folder: &Path, widths: [usize; 3]) -> Result<(), ExportError> {
        let data = folder.join("data");
        let bytes = size(&data).map_err(unwritable(&data))?;
        let Self { id, info, episodes, steps, longest } = self;
        let [observation, goal, action] = widths;
        let anywhere = |width| space("float64", width, FAR);
        let subspaces = json!({
            "observation": anywhere(observation),
            "achieved_goal": anywhere(goal),
            "desired_goal": anywhere(goal),
        });
        let observations = json!({ "type": "Dict", "subspaces": subspaces });
        let RecordingInfo { task, options, rher, .. } = &info;
        let mut metadata = json!({
            "dataset_id": id.to_string(),
            "total_episodes": episodes,
            "total_steps": steps,
            // In megabytes, to a tenth, as Minari counts them.
            "dataset_size": (bytes as f64 / 1e5).round() / 10.0,
            "data_format": "parquet",
            "jpeg_encoding": false,
            "observation_space": observations.to_string(),
            "action_space": space("float32", action, 1.0).to_string(),
            "minari_version": VERSION,
            "algorithm_name": "Relay Hindsight Experience Replay",
            "description": format!("`{task}` with options {options}, by rher {rher}"),
        });
        if let Some(spec) = environment(&info, longest) {
            metadata["env_spec"] = spec.to_string().into();
            metadata["eval_env_spec"] = spec.to_string().into();
        }
        write(&data.join("metadata.json"), format!("{metadata:#}\n").as_bytes())
    }
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
        ("observation", Column::WideLists(observation, observations.clone())),
        ("achieved_goal", Column::WideLists(goal, achieved.clone())),
        ("desired_goal", Column::WideLists(goal, desired.repeat(frames))),
    ];
    vec![
        ("observations", Column::Group(observations)),
        ("actions", Column::Lists(action, actions)),
        ("rewards", Column::WideNumbers(rewards)),
        ("terminations", Column::Flags(vec![false; frames])),
        ("truncations", Column::Flags(truncations)),
        // Of flags without a list Minari 0.5.4 makes combined datasets that it cannot read.
        ("infos", Column::Group(vec![("is_success", Column::FlagLists(successes.clone()))])),
    ]
}

/// A space of vectors as Minari writes it.
fn space(kind: &str, width: usize, limit: f64) -> Value {
    json!({
        "type": "Box",
        "dtype": kind,
        "shape": [width],
        "low": vec![-limit; width],
        "high": vec![limit; width],
    })
}

/// The Gymnasium environment of the Python package that the episodes can be played in again; none
/// for a task or options that are not part of this program.
fn environment(info: &RecordingInfo, steps: usize) -> Option<Value> {
    let task: Task = info.task.parse().ok()?;
    let options: Options =
        if info.options.is_empty() { Options::default() } else { info.options.parse().ok()? };
    let options = options.check(task.options()).ok()?;
    let [set, unset] = [options, Options::of(task.options())]
        .map(|options| serde_json::from_str::<Value>(&options.to_string()).unwrap_or_default());
    // An environment that was made without options has none in its specification.
    let mut kwargs = Map::from_iter([("task".to_owned(), info.task.clone().into())]);
    for (section, keyword) in [("task", "options"), ("randomize", "randomize")] {
        let entries = set[section].as_object().into_iter().flatten();
        let changed: Map<_, _> = entries
            .filter(|(name, value)| unset[section][*name] != **value)
            .map(|(name, value)| (name.clone(), value.clone()))
            .collect();
        if !changed.is_empty() {
            kwargs.insert(keyword.to_owned(), changed.into());
        }
    }
    Some(json!({
        "id": task.gymnasium_id()?,
        "entry_point": "rher.env:TaskEnv",
        "reward_threshold": null,
        "nondeterministic": false,
        "max_episode_steps": steps,
        "order_enforce": false,
        "disable_env_checker": true,
        "kwargs": kwargs,
        "additional_wrappers": [],
        "vector_entry_point": "rher.vector:TaskVectorEnv",
    }))
}

/// Bytes below a folder, those of folders included.
fn size(folder: &Path) -> io::Result<u64> {
    let mut bytes = 0;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        bytes += metadata.len();
        if metadata.is_dir() {
            bytes += size(&entry.path())?;
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identities_are_those_that_minari_reads() {
        for id in ["rher/push-v0", "push-v12", "a/b_c/d-e-v1", "rher/push-v1-v2", "ab/v-v3"] {
            assert_eq!(id.parse().map(|id: DatasetId| id.to_string()), Ok(id.to_owned()));
        }
        for id in ["", "push", "rher/push", "rher/push-v", "rher/push-vx", "/push-v0", "a/push-v0"]
        {
            assert_eq!(id.parse::<DatasetId>(), Err(InvalidDatasetId), "{id}");
        }
        for id in ["rher//push-v0", "../push-v0", "rher/pu sh-v0", "rher/-v0", "rher/push-v0/"] {
            assert_eq!(id.parse::<DatasetId>(), Err(InvalidDatasetId), "{id}");
        }
    }

    #[test]
    fn an_environment_names_only_the_options_that_were_set() {
        let info = |options: &str| RecordingInfo {
            task: "cue-push".to_owned(),
            options: options.to_owned(),
            source: crate::Source::Policy,
            seed: 0,
            reach_distance: 0.05,
            subtasks: 2,
            run: None,
            config: String::new(),
            policy_sha256: String::new(),
            rher: String::new(),
            rapier: String::new(),
        };
        let spec = environment(&info(""), 20).unwrap();
        assert_eq!(spec["id"], "rher/CuePush-v0");
        assert_eq!(spec["kwargs"], json!({ "task": "cue-push" }));
        let options = r#"{"task": {"noise": 0.0}, "randomize": {"friction": [0.7, 1.5]}}"#;
        let expected = json!({
            "task": "cue-push",
            "options": { "noise": 0.0 },
            "randomize": { "friction": [0.7, 1.5] },
        });
        assert_eq!(environment(&info(options), 20).unwrap()["kwargs"], expected);
    }
}
