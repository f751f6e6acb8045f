//! Policies as [ONNX](https://onnx.ai) models, for runtimes on robots and elsewhere.

mod contract;
mod encoder;
mod graph;
mod inputs;
mod network;
mod order;
mod proto;

use super::file::{self, PolicyError};
use super::model::Policy;
use crate::files::{self, FileError};
use contract::{Contract, Model};
use graph::Graph;
use inputs::Inputs;
use prost::Message as _;
use proto::{ModelProto, OperatorSetIdProto, StringStringEntryProto};
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Version of the operators, which ONNX Runtime has since 1.12 (2022).
const OPSET: i64 = 17;

/// Version of the file's format that came with them.
const IR_VERSION: i64 = 8;

/// A policy as an ONNX model: a graph with everything that it needs to act, in which the normalizer,
/// the encoded goal, the order of the objects and the network are operators.
///
/// Its inputs are the parts of the observation of a Gymnasium `GoalEnv`, `[batch, width]` in single
/// precision; its output is `action`, `[batch, action_dim]`, within −1 and 1, that of the policy for
/// the whole task. Where the policy has learned in which order to place the objects, two more inputs
/// are what the episode began with.
///
/// ```no_run
/// use rher_core::OnnxModel;
///
/// let model = OnnxModel::of_file("policy.safetensors".as_ref())?;
/// model.save("policy.onnx".as_ref())?;
/// # Ok::<(), rher_core::OnnxError>(())
/// ```
#[derive(Clone, Debug)]
pub struct OnnxModel {
    policy: Policy,
    policy_sha256: String,
    gripper: usize,
    bytes: Vec<u8>,
}

/// A policy cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OnnxError {
    /// The policy file cannot be read, or is none.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The policy does not say where the gripper is.
    #[error(
        "the policy of `{task}` does not say where in an observation the gripper is, because an \
         earlier version wrote it: train it with this version"
    )]
    NoGripper {
        /// What it was trained for.
        task: String,
    },
    /// The goals of the policy are more than positions.
    #[error(
        "the goals of `{task}` say more of objects than where they should be ({goals}), which cannot \
         be exported: expected a policy whose goals are positions"
    )]
    Goals {
        /// What it was trained for.
        task: String,
        /// What its goals are.
        goals: String,
    },
    /// The numbers of the policy are not those that a model has.
    #[error(
        "the policy of `{task}` has actions or positions that cannot be exported: expected actions \
         within -1 and 1, and positions of three numbers"
    )]
    Units {
        /// What it was trained for.
        task: String,
    },
    /// The model would have another name than that of an ONNX model.
    #[error("the model is `{}`, expected a name that ends in .onnx", path.display())]
    Name {
        /// Where it should be.
        path: PathBuf,
    },
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl OnnxModel {
    /// The model of the policy in a file.
    ///
    /// # Errors
    ///
    /// When the file cannot be read or holds no policy, or when the policy does not say where in an
    /// observation the gripper is.
    pub fn of_file(path: &Path) -> Result<Self, OnnxError> {
        let file = file::read(path).map_err(PolicyError::from)?;
        Self::of(Policy::from_bytes(&file, path)?, &file)
    }

    /// The model of a policy.
    ///
    /// # Errors
    ///
    /// When the policy does not say where in an observation the gripper is.
    pub fn of_policy(policy: &Policy) -> Result<Self, OnnxError> {
        Self::of(policy.clone(), &policy.to_bytes())
    }

    fn of(policy: Policy, file: &[u8]) -> Result<Self, OnnxError> {
        let task = || policy.info().task.clone();
        let tail = policy.encoder.tail;
        if !tail.is_none() {
            return Err(OnnxError::Goals { task: task(), goals: tail.to_string() });
        }
        if has_own_units(&policy) {
            return Err(OnnxError::Units { task: task() });
        }
        let gripper = gripper(&policy).ok_or_else(|| OnnxError::NoGripper { task: task() })?;
        let policy_sha256 = sha256(file);
        let model = graph_of(&policy, &policy_sha256, gripper);
        Ok(Self { bytes: model.encode_to_vec(), policy, policy_sha256, gripper })
    }

    /// Writes the model to a file whose name ends in `.onnx`, and beside it, in a file of JSON that
    /// is returned, what its numbers are: names, shapes, units, the frame, the rate, limits, the task
    /// and hashes. Each file is complete or not there.
    ///
    /// # Errors
    ///
    /// When the name has another end, or a file cannot be written.
    #[expect(clippy::missing_panics_doc, reason = "it cannot panic, as the expectation says")]
    pub fn save(&self, path: &Path) -> Result<PathBuf, OnnxError> {
        let name = path.file_name().filter(|_| path.extension().is_some_and(|it| it == "onnx"));
        let name = name.ok_or_else(|| OnnxError::Name { path: path.to_owned() })?;
        let model = Model {
            file: name.to_string_lossy().into_owned(),
            sha256: sha256(&self.bytes),
            opset: OPSET,
        };
        let inputs = Inputs::new(&self.policy, self.gripper);
        let contract = Contract::new(&self.policy, &self.policy_sha256, inputs, model);
        let mut contract = serde_json::to_string_pretty(&contract).expect("its keys are strings");
        contract.push('\n');
        let beside = path.with_extension("json");
        files::replace(path, &self.bytes)?;
        files::replace(&beside, contract.as_bytes())?;
        Ok(beside)
    }
}

/// Where in an observation the three numbers of the gripper's position begin: they have names, or
/// the environment says so in its settings.
fn gripper(policy: &Policy) -> Option<usize> {
    let is_position = |names: &[String]| {
        names
            .iter()
            .zip(["x", "y", "z"])
            .all(|(name, axis)| name.strip_prefix("gripper.position.").is_some_and(|it| it == axis))
    };
    let named = policy.names().observation.windows(3).position(is_position);
    named.or_else(|| {
        let settings: serde_json::Value = serde_json::from_str(&policy.info().variant).ok()?;
        let place = usize::try_from(settings.get("gripper")?.as_u64()?).ok()?;
        let is_inside = place.checked_add(3)? <= policy.info().obs_dim;
        is_inside.then_some(place)
    })
}

/// Whether it is of someone else's environment, whose actions have other limits, or whose positions
/// have no height.
fn has_own_units(policy: &Policy) -> bool {
    let settings = serde_json::from_str(&policy.info().variant);
    let settings: serde_json::Value = settings.unwrap_or_default();
    ["limits", "axes"].iter().any(|key| settings.get(key).is_some_and(|it| !it.is_null()))
}

fn graph_of(policy: &Policy, policy_sha256: &str, gripper: usize) -> ModelProto {
    let Policy { info, encoder, shape, parameters, run: _, interface: _ } = policy;
    let (graph, inputs) = (Graph::default(), Inputs::new(policy, gripper));
    let action =
        network::action(&graph, encoder::encoded(&graph, inputs, encoder), shape, parameters);
    let used: Vec<_> = inputs.used().map(|name| graph.input(name)).collect();
    let action = network::unless_finite(&graph, action, &used);
    let metadata = [("task", &*info.task), ("policy_sha256", policy_sha256)];
    ModelProto {
        ir_version: Some(IR_VERSION),
        producer_name: Some("rher".to_owned()),
        producer_version: Some(env!("CARGO_PKG_VERSION").to_owned()),
        graph: Some(graph.finish(&inputs.all(), ("action", info.action_dim), action)),
        opset_import: vec![OperatorSetIdProto {
            domain: Some(String::new()),
            version: Some(OPSET),
        }],
        metadata_props: metadata
            .map(|(key, value)| StringStringEntryProto {
                key: Some(key.to_owned()),
                value: Some(value.to_owned()),
            })
            .into(),
    }
}

/// As `sha256sum` prints it.
fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
