//! What has to be known to run a model.

use super::inputs::Inputs;
use crate::policy::{Policy, RunId};
use serde::Serialize;

/// Version of the file.
const VERSION: u32 = 1;

/// The file beside a model. Its lists of names and units are empty where nobody knows them.
#[derive(Serialize)]
pub(super) struct Contract<'a> {
    #[serde(rename = "contract")]
    version: u32,
    task: &'a str,
    /// Settings of the environment: a table, or its own words.
    settings: serde_json::Value,
    objects: &'a [String],
    rate_hz: Option<f32>,
    frame: &'a str,
    inputs: Vec<Rows>,
    outputs: [Actions; 1],
    model: Model,
    policy: Origin<'a>,
    rher: &'static str,
}

/// Rows of numbers.
#[derive(Serialize)]
struct Rows {
    name: &'static str,
    meaning: &'static str,
    dtype: &'static str,
    shape: (&'static str, usize),
    names: Vec<String>,
    units: Vec<String>,
}

#[derive(Serialize)]
struct Actions {
    #[serde(flatten)]
    rows: Rows,
    limits: [f32; 2],
}

/// The file of the model.
#[derive(Serialize)]
pub(super) struct Model {
    pub(super) file: String,
    pub(super) sha256: String,
    pub(super) opset: i64,
}

#[derive(Serialize)]
struct Origin<'a> {
    sha256: &'a str,
    run: Option<RunId>,
}

impl<'a> Contract<'a> {
    pub(super) fn new(
        policy: &'a Policy,
        policy_sha256: &'a str,
        inputs: Inputs<'_>,
        model: Model,
    ) -> Self {
        let (info, names, control) = (policy.info(), policy.names(), policy.control());
        let rows = |(name, width)| rows(policy, inputs, name, width);
        let actions = Rows {
            name: "action",
            meaning: "what to do until the next one; NaN where an input is not finite",
            dtype: "float32",
            shape: ("batch", info.action_dim),
            names: names.action.clone(),
            units: control.action_units.clone(),
        };
        let settings = serde_json::from_str(&info.variant);
        Self {
            version: VERSION,
            task: &info.task,
            settings: settings.unwrap_or_else(|_| info.variant.clone().into()),
            objects: &names.objects,
            rate_hz: control.rate_hz,
            frame: &control.frame,
            inputs: inputs.all().into_iter().map(rows).collect(),
            outputs: [Actions { rows: actions, limits: [-1.0, 1.0] }],
            model,
            policy: Origin { sha256: policy_sha256, run: policy.run() },
            rher: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// What is to be known of one of the inputs.
fn rows(policy: &Policy, inputs: Inputs<'_>, name: &'static str, width: usize) -> Rows {
    let meaning = match name {
        "achieved_goal" if inputs.is_reach() => "not used: what is to be reached stays where it is",
        "achieved_goal" => "where the objects are",
        "desired_goal" => "where the objects should be",
        "first_observation" => "`observation` when the episode began",
        "first_achieved_goal" => "where the objects were when the episode began",
        _ => "`observation` of the environment",
    };
    let (names, units) = if name.ends_with("_goal") {
        let of_object = |object| ["x", "y", "z"].map(|axis| format!("{object}.position.{axis}"));
        let names = policy.names().objects.iter().flat_map(of_object).collect();
        (names, vec!["m".to_owned(); width])
    } else {
        (policy.names().observation.clone(), policy.control().observation_units.clone())
    };
    Rows { name, meaning, dtype: "float32", shape: ("batch", width), names, units }
}
