//! A trained policy on its own: what acts, what is saved, what is deployed.

use crate::env::EnvSpec;
use crate::files::{self, FileError};
use crate::goal::{Achieved, Desired, EncodedGoal, Stage};
use crate::input::InputEncoder;
use crate::learner::infer::Inference;
use crate::learner::network::Shape;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Version of the policy file.
const VERSION: u32 = 1;

/// Key of the description in the file's metadata.
const METADATA: &str = "rher";

/// A frozen actor with everything it needs to act: networks do not know what a goal is.
#[derive(Clone, Debug, PartialEq)]
pub struct Policy {
    info: PolicyInfo,
    encoder: InputEncoder,
    shape: Shape,
    parameters: Vec<f32>,
}

/// What a policy was trained for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolicyInfo {
    /// Name of the environment.
    pub task: String,
    /// Settings that the environment was made with, in its own words; empty where it has none.
    #[serde(default)]
    pub variant: String,
    /// Objects in it.
    pub objects: usize,
    /// Sub-tasks of its task, from the first.
    pub subtasks: usize,
    /// Sub-tasks before the first one that it was trained for: none, but for plain hindsight,
    /// which trains the last alone.
    pub untrained: usize,
    /// Numbers in an observation.
    #[serde(rename = "observation")]
    pub obs_dim: usize,
    /// Numbers in an action.
    #[serde(rename = "action")]
    pub action_dim: usize,
    /// The paper's d, by which stages are told, in metres.
    pub reach_distance: f32,
}

/// All of a policy file that is not a tensor.
#[derive(Serialize, Deserialize)]
struct Metadata {
    version: u32,
    #[serde(rename = "about")]
    info: PolicyInfo,
    shape: Shape,
    encoder: InputEncoder,
}

/// A policy file could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum PolicyError {
    /// The file system refused.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not a policy of this version, or is damaged.
    #[error("`{}` is not a policy file of this program: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}

/// A policy does not fit an environment.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the policy was trained for {expected}, but the environment has {found}")]
pub struct Mismatch {
    /// Widths of the policy.
    pub expected: String,
    /// Widths of the environment.
    pub found: String,
}

impl Policy {
    /// The policy of an actor with these parameters.
    pub fn new(
        info: PolicyInfo,
        encoder: InputEncoder,
        shape: Shape,
        parameters: Vec<f32>,
    ) -> Self {
        Self { info, encoder, shape, parameters }
    }

    /// What it was trained for.
    pub fn info(&self) -> &PolicyInfo {
        &self.info
    }

    /// What the network sees.
    #[cfg(feature = "train")]
    pub(crate) fn encoder(&self) -> &InputEncoder {
        &self.encoder
    }

    /// Something that acts with this policy, with buffers of its own.
    pub fn actor(&self) -> Actor<'_> {
        Actor {
            policy: self,
            input: vec![0.0; self.encoder.width()],
            inference: Inference::new(&self.shape),
        }
    }

    /// Whether it can act in environments like `spec`.
    pub fn check<const N: usize>(&self, spec: &EnvSpec<N>) -> Result<(), Mismatch> {
        let widths = |objects, observation, action| {
            format!("{objects} objects, observations of {observation} and actions of {action}")
        };
        let PolicyInfo { objects, obs_dim: observation, action_dim: action, .. } = self.info;
        let expected = widths(objects, observation, action);
        let found = widths(N, spec.obs_dim, spec.action_dim);
        if expected == found { Ok(()) } else { Err(Mismatch { expected, found }) }
    }

    /// Writes the policy to a file: its tensors, and all else in the metadata.
    ///
    /// The file is complete or not there: it is written beside its place and renamed.
    pub fn save(&self, path: &Path) -> Result<(), PolicyError> {
        let metadata = Metadata {
            version: VERSION,
            info: self.info.clone(),
            shape: self.shape.clone(),
            encoder: self.encoder.clone(),
        };
        let bytes: Vec<u8> = self.parameters.iter().flat_map(|x| x.to_le_bytes()).collect();
        let malformed = |problem: String| PolicyError::Malformed { path: path.into(), problem };
        let tensors = self
            .shape
            .tensors()
            .into_iter()
            .map(|tensor| {
                let bytes = &bytes[4 * tensor.range.start..4 * tensor.range.end];
                let view = TensorView::new(Dtype::F32, tensor.dims, bytes);
                view.map(|view| (tensor.name, view)).map_err(|error| malformed(error.to_string()))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let description =
            serde_json::to_string(&metadata).map_err(|error| malformed(error.to_string()))?;
        let metadata = HashMap::from([(METADATA.to_owned(), description)]);
        let file = safetensors::serialize(tensors, Some(metadata))
            .map_err(|error| malformed(error.to_string()))?;
        Ok(files::replace(path, &file)?)
    }

    /// Reads a policy from a file.
    pub fn load(path: &Path) -> Result<Self, PolicyError> {
        let file = std::fs::read(path).map_err(FileError::read(path))?;
        let malformed = |problem: String| PolicyError::Malformed { path: path.to_owned(), problem };
        let (_, header) =
            SafeTensors::read_metadata(&file).map_err(|error| malformed(error.to_string()))?;
        let description = header
            .metadata()
            .as_ref()
            .and_then(|metadata| metadata.get(METADATA))
            .ok_or_else(|| malformed(format!("its metadata has no `{METADATA}`")))?;
        let Metadata { version, info, shape, encoder } = serde_json::from_str(description)
            .map_err(|error| malformed(format!("its metadata: {error}")))?;
        if version != VERSION {
            return Err(malformed(format!("it has version {version}, expected {VERSION}")));
        }
        let tensors =
            SafeTensors::deserialize(&file).map_err(|error| malformed(error.to_string()))?;
        let mut parameters = Vec::with_capacity(shape.parameters());
        for tensor in shape.tensors() {
            let view =
                tensors.tensor(&tensor.name).map_err(|error| malformed(error.to_string()))?;
            if view.dtype() != Dtype::F32 || view.shape() != tensor.dims {
                return Err(malformed(format!(
                    "tensor `{}` is {:?} {:?}, expected F32 {:?}",
                    tensor.name,
                    view.dtype(),
                    view.shape(),
                    tensor.dims
                )));
            }
            let (numbers, _) = view.data().as_chunks::<4>();
            parameters.extend(numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)));
        }
        let policy = Self { info, encoder, shape, parameters };
        policy.check_widths().map_err(malformed)?;
        Ok(policy)
    }

    fn check_widths(&self) -> Result<(), String> {
        let Self { info, encoder, shape, parameters } = self;
        let facts = [
            ("network input", shape.inputs, encoder.width()),
            ("action", shape.outputs, info.action_dim),
            ("observation", encoder.observation(), info.obs_dim),
            ("objects", encoder.objects(), info.objects),
        ];
        if let Some((what, found, expected)) = facts.iter().find(|(_, a, b)| a != b) {
            return Err(format!("{what}: {found} in one place and {expected} in another"));
        }
        if info.untrained >= info.subtasks || info.subtasks > 2 * info.objects {
            let PolicyInfo { objects, subtasks, untrained, .. } = info;
            return Err(format!(
                "{subtasks} sub-tasks, {untrained} of them untrained, for {objects} objects"
            ));
        }
        if !encoder.is_consistent() {
            return Err("the order of its objects does not fit its observation".to_owned());
        }
        match parameters.iter().position(|x| !x.is_finite()) {
            Some(index) => Err(format!("parameter {index} is {}", parameters[index])),
            None => Ok(()),
        }
    }
}

/// Acts with a policy; nothing is allocated from one action to the next.
#[derive(Debug)]
pub struct Actor<'a> {
    policy: &'a Policy,
    input: Vec<f32>,
    inference: Inference,
}

impl Actor<'_> {
    /// Writes the action of the policy for the sub-task that ends with `stage`: the one network,
    /// fed with the goal encoded for that stage (eq. 7).
    ///
    /// # Shapes
    ///
    /// `observation`: `[observation]`, raw; `action`: `[action]`, each number in [−1, 1].
    pub fn act<const N: usize>(
        &mut self,
        stage: Stage<N>,
        observation: &[f32],
        achieved: &Achieved<N>,
        desired: &Desired<N>,
        action: &mut [f32],
    ) {
        let goal = EncodedGoal::new(stage, achieved, desired);
        self.policy.encoder.write(observation, achieved, &goal, &mut self.input);
        self.inference.act(&self.policy.parameters, &self.input, action);
    }
}
