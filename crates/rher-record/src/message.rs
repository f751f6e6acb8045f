//! What a recording consists of: timed messages on five topics.
//!
//! Two are Foxglove's own, as protobuf; the others are JSON, whose numbers are written so that
//! every bit of a 32-bit float comes back.

use crate::info::as_text;
use crate::schemas;
use foxglove::messages::{FrameTransforms, SceneUpdate};
use foxglove::{Encode, Schema};
use rher_core::explore::ActionSource;
use rher_core::goal::Position;
use serde::{Deserialize, Serialize};

/// A message and when it was sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Timed {
    /// Nanoseconds.
    pub time: u64,
    /// What was sent.
    pub message: Message,
}

/// A message of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// Where everything is, in every step.
    Transforms(FrameTransforms),
    /// What everything looks like, at the beginning of an episode.
    Scene(SceneUpdate),
    /// The beginning of an episode.
    Begin(Begin),
    /// What was reached, in every step.
    Frame(Frame),
    /// What was done, in every step but the last.
    Action(Action),
}

/// Where messages of one kind are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// `/tf`
    Transforms,
    /// `/scene`
    Scene,
    /// `/episode`
    Begin,
    /// `/frame`
    Frame,
    /// `/action`
    Action,
}

impl Topic {
    /// Every topic.
    pub const ALL: [Self; 5] =
        [Self::Transforms, Self::Scene, Self::Begin, Self::Frame, Self::Action];

    /// As in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Transforms => "/tf",
            Self::Scene => "/scene",
            Self::Begin => "/episode",
            Self::Frame => "/frame",
            Self::Action => "/action",
        }
    }

    /// `protobuf` or `json`.
    pub const fn encoding(self) -> &'static str {
        match self {
            Self::Transforms | Self::Scene => "protobuf",
            Self::Begin | Self::Frame | Self::Action => "json",
        }
    }

    /// What its messages look like.
    pub(crate) fn schema(self) -> Schema {
        let own = |name, text: &'static str| Schema::new(name, "jsonschema", text.as_bytes());
        match self {
            Self::Transforms => FrameTransforms::get_schema().expect("Foxglove's own"),
            Self::Scene => SceneUpdate::get_schema().expect("Foxglove's own"),
            Self::Begin => own("rher.Episode", schemas::BEGIN),
            Self::Frame => own("rher.Frame", schemas::FRAME),
            Self::Action => own("rher.Action", schemas::ACTION),
        }
    }
}

impl Message {
    /// Where it belongs.
    pub fn topic(&self) -> Topic {
        match self {
            Self::Transforms(_) => Topic::Transforms,
            Self::Scene(_) => Topic::Scene,
            Self::Begin(_) => Topic::Begin,
            Self::Frame(_) => Topic::Frame,
            Self::Action(_) => Topic::Action,
        }
    }

    /// As in the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        fn protobuf(message: &impl Encode) -> Vec<u8> {
            let mut bytes = Vec::new();
            message.encode(&mut bytes).expect("a vector has room");
            bytes
        }
        fn json(message: &impl Serialize) -> Vec<u8> {
            serde_json::to_vec(message).expect("numbers and text")
        }
        match self {
            Self::Transforms(message) => protobuf(message),
            Self::Scene(message) => protobuf(message),
            Self::Begin(message) => json(message),
            Self::Frame(message) => json(message),
            Self::Action(message) => json(message),
        }
    }
}

/// A point in the world frame, in meters; fields, since Foxglove plots no arrays of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Away from the robot.
    pub x: f32,
    /// To its left.
    pub y: f32,
    /// Upwards.
    pub z: f32,
}

impl From<Position> for Place {
    fn from(position: Position) -> Self {
        Self { x: position.x, y: position.y, z: position.z }
    }
}

/// `/episode`: an episode begins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Begin {
    /// Number of the episode among those of its run, counted from 0.
    pub episode: u64,
    /// Seed that the environment was reset with; text, since not every reader keeps 64 bits.
    #[serde(with = "as_text")]
    pub seed: u64,
    /// Actions that follow.
    pub steps: usize,
    /// Where each object should go, in relay order.
    pub targets: Vec<Place>,
    /// How near an object counts as at its target, in meters, in relay order.
    pub tolerances: Vec<f32>,
    /// How near the gripper counts as at an object, in meters.
    pub reach_tolerance: f32,
}

/// `/frame`: what was reached.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Number of the episode.
    pub episode: u64,
    /// Steps taken before.
    pub step: usize,
    /// Stage of the relay (eq. 6), counted from 1.
    pub stage: usize,
    /// Whether the task is solved.
    pub success: bool,
    /// How far the task is from being solved: mean distance of objects to their targets, or of the
    /// gripper to the object it should reach, in meters.
    pub distance: f32,
    /// How far each object is from its target, in meters.
    pub distances: Vec<f32>,
    /// Reward of the step that ended here; none where an episode begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reward: Option<f32>,
    /// Rewards so far, added up.
    #[serde(rename = "return")]
    pub sum: f32,
    /// Grip center, as goals have it.
    pub gripper: Place,
    /// Where each object is, as goals have it, in relay order.
    pub objects: Vec<Place>,
    /// What the agent sees.
    pub observation: Vec<f32>,
}

/// `/action`: what was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Action {
    /// Number of the episode.
    pub episode: u64,
    /// Steps taken before.
    pub step: usize,
    /// As it was chosen: the environment gets it clipped to [−1, 1].
    pub action: Vec<f32>,
    /// Who chose it.
    pub decider: ActionSource,
    /// The sub-task whose policy it was, counted from 1; the learner's where chance chose.
    pub subtask: usize,
    /// What the first critic expects of it in that sub-task; none where there is no critic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q: Option<f32>,
}
