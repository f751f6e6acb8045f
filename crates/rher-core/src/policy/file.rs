//! The policy file: tensors in the safetensors format, all else as JSON in its metadata.
//!
//! The first entry of the JSON is the CRC-32 of the whole file, computed with zeros in its own place,
//! so that no damage goes unnoticed. Files of version 1 have none.

use super::info::PolicyInfo;
use super::model::{Interface, Policy};
use super::run_id::RunId;
use crate::files::{self, FileError};
use crate::input::InputEncoder;
use crate::learner::network::Shape;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Version of the policy file.
const VERSION: u32 = 2;

/// The last version without a checksum, which is still read.
const WITHOUT_CHECKSUM: u32 = 1;

/// Largest file in bytes.
const LARGEST: u64 = 1 << 30;

/// Largest header in bytes: that of a policy has about 10 kB.
const LARGEST_HEADER: u64 = 1 << 20;

/// What stands before the checksum, as the header of the file has it: JSON in a string of JSON.
const BEFORE_CHECKSUM: &[u8] = br#"\"crc32\":\""#;

/// What stands in the checksum's place while it is computed.
const NO_CHECKSUM: &str = "00000000";

/// Key of the description in the file's metadata.
const METADATA: &str = "rher";

/// All of a policy file that is not a tensor.
#[derive(Serialize, Deserialize)]
struct Metadata {
    #[serde(default)]
    crc32: String,
    version: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    run: Option<RunId>,
    #[serde(rename = "about")]
    info: PolicyInfo,
    #[serde(default)]
    interface: Interface,
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
        Self::from_bytes(&read(path)?, path)
    }

    /// What is in the policy's file: its tensors, and all else in the metadata.
    #[expect(clippy::missing_panics_doc, reason = "it cannot panic, as the expectations say")]
    pub fn to_bytes(&self) -> Vec<u8> {
        let metadata = Metadata {
            crc32: NO_CHECKSUM.to_owned(),
            version: VERSION,
            run: self.run,
            info: self.info.clone(),
            interface: (*self.interface).clone(),
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
        let mut file = safetensors::serialize(tensors, Some(metadata))
            .expect("every tensor is as long as it says");
        let place = checksum_place(&file).expect("it was written just now");
        let checksum = format!("{:08x}", crc32fast::hash(&file));
        file[place].copy_from_slice(checksum.as_bytes());
        file
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote; an error calls it `path`.
    pub fn from_bytes(file: &[u8], path: &Path) -> Result<Self, PolicyError> {
        let malformed = |problem: String| PolicyError::Malformed { path: path.to_owned(), problem };
        if let Some(length) = header_length(file).filter(|length| *length > LARGEST_HEADER) {
            return Err(malformed(format!(
                "its header has {length} bytes, expected at most {LARGEST_HEADER}"
            )));
        }
        let (_, header) =
            SafeTensors::read_metadata(file).map_err(|error| malformed(error.to_string()))?;
        let description = header
            .metadata()
            .as_ref()
            .and_then(|metadata| metadata.get(METADATA))
            .ok_or_else(|| malformed(format!("its metadata has no `{METADATA}`")))?;
        let Metadata { crc32: _, version, run, info, interface, shape, encoder } =
            serde_json::from_str(description)
                .map_err(|error| malformed(format!("its metadata: {error}")))?;
        match version {
            WITHOUT_CHECKSUM => {}
            VERSION => check_checksum(file).map_err(malformed)?,
            _ => {
                return Err(malformed(format!(
                    "it has version {version}, expected {WITHOUT_CHECKSUM} or {VERSION}"
                )));
            }
        }
        // Before anything is made that is as large as the metadata say.
        let numbers = shape.checked_parameters().filter(|count| *count <= file.len() / 4);
        if numbers.is_none() {
            return Err(malformed(format!(
                "its metadata describe a larger network than fits in its {} bytes",
                file.len()
            )));
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
        let interface = Arc::new(interface);
        let policy = Self { info, encoder, shape, parameters, run, interface };
        policy.check_widths().map_err(malformed)?;
        Ok(policy)
    }

    fn check_widths(&self) -> Result<(), String> {
        let Self { info, encoder, shape, parameters, run: _, interface } = self;
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
        let Interface { names, control } = &**interface;
        let of_names =
            names.check(info.objects, info.obs_dim, info.action_dim, encoder.tail().parts().len());
        if let Err((field, found, expected)) =
            of_names.and(control.check(info.obs_dim, info.action_dim))
        {
            return Err(format!("`{field}` has {found}, expected {expected}"));
        }
        encoder.check()?;
        if !(info.reach_distance.is_finite() && info.reach_distance >= 0.0) {
            return Err(format!("a reach distance of {} m", info.reach_distance));
        }
        match parameters.iter().position(|x| !x.is_finite()) {
            Some(index) => Err(format!("parameter {index} is {}", parameters[index])),
            None => Ok(()),
        }
    }
}

/// The bytes of a policy file, or the first ones of a file that is none.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let starts_right = |start: &[u8]| {
        header_length(start).is_some_and(|length| (1..=LARGEST_HEADER).contains(&length))
    };
    files::read_from(path, 8, starts_right, LARGEST)
}

/// Bytes of a file's header, as its first eight bytes say.
fn header_length(file: &[u8]) -> Option<u64> {
    Some(u64::from_le_bytes(*file.first_chunk()?))
}

/// Where the digits of the checksum stand in a file.
fn checksum_place(file: &[u8]) -> Option<std::ops::Range<usize>> {
    let length = header_length(file)?;
    let header = file.get(8..8_usize.checked_add(usize::try_from(length).ok()?)?)?;
    let is_entry = |window: &[u8]| window == BEFORE_CHECKSUM;
    let start = header.windows(BEFORE_CHECKSUM.len()).position(is_entry)?;
    let digits = 8 + start + BEFORE_CHECKSUM.len();
    file.get(digits..digits + NO_CHECKSUM.len())?;
    Some(digits..digits + NO_CHECKSUM.len())
}

fn check_checksum(file: &[u8]) -> Result<(), String> {
    let place = checksum_place(file).ok_or("its checksum is missing")?;
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&file[..place.start]);
    hasher.update(NO_CHECKSUM.as_bytes());
    hasher.update(&file[place.end..]);
    let computed = format!("{:08x}", hasher.finalize());
    match &file[place] {
        expected if *expected == *computed.as_bytes() => Ok(()),
        expected => {
            let expected = expected.escape_ascii();
            Err(format!("it is damaged: its checksum is {computed}, expected {expected}"))
        }
    }
}
