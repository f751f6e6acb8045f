//! The policy file: tensors in the safetensors format, all else as JSON in its metadata.

use super::info::PolicyInfo;
use super::model::Policy;
use crate::files::{self, FileError};
use crate::input::InputEncoder;
use crate::learner::network::Shape;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Version of the policy file.
const VERSION: u32 = 1;

/// Key of the description in the file's metadata.
const METADATA: &str = "rher";

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
#[non_exhaustive]
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

impl Policy {
    /// Writes the policy to a file, see [`to_bytes`](Self::to_bytes).
    ///
    /// The file is complete or not there: it is written beside its place and renamed.
    pub fn save(&self, path: &Path) -> Result<(), PolicyError> {
        Ok(files::replace(path, &self.to_bytes())?)
    }

    /// Reads a policy from a file.
    pub fn load(path: &Path) -> Result<Self, PolicyError> {
        let file = std::fs::read(path).map_err(FileError::read(path))?;
        Self::from_bytes(&file, path)
    }

    /// What is in the policy's file: its tensors, and all else in the metadata.
    pub fn to_bytes(&self) -> Vec<u8> {
        let metadata = Metadata {
            version: VERSION,
            info: self.info.clone(),
            shape: self.shape.clone(),
            encoder: self.encoder.clone(),
        };
        let bytes: Vec<u8> = self.parameters.iter().flat_map(|x| x.to_le_bytes()).collect();
        let tensors = self.shape.tensors().into_iter().map(|tensor| {
            let bytes = &bytes[4 * tensor.range.start..4 * tensor.range.end];
            let view = TensorView::new(Dtype::F32, tensor.dims, bytes);
            (tensor.name, view.expect("a range is as long as its dimensions say"))
        });
        let description = serde_json::to_string(&metadata).expect("its keys are strings");
        let metadata = HashMap::from([(METADATA.to_owned(), description)]);
        safetensors::serialize(tensors, Some(metadata)).expect("every tensor is as long as it says")
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote; an error calls it `path`.
    pub fn from_bytes(file: &[u8], path: &Path) -> Result<Self, PolicyError> {
        let malformed = |problem: String| PolicyError::Malformed { path: path.to_owned(), problem };
        let (_, header) =
            SafeTensors::read_metadata(file).map_err(|error| malformed(error.to_string()))?;
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
            SafeTensors::deserialize(file).map_err(|error| malformed(error.to_string()))?;
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
