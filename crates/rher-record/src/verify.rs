//! Proof that an episode was real: played again, every message comes out the same, bit for bit.

use crate::message::{Timed, Topic};
use crate::player::{PlayError, Player};
use crate::read::{Recorded, Sent};
use foxglove::Decode;
use foxglove::messages::{FrameTransforms, SceneUpdate};
use rher_envs::Simulated;
use serde_json::Value;

/// The first place where a recording is not what happens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of the episode.
    pub episode: u64,
    /// Steps taken before.
    pub step: usize,
    /// Such as `/frame observation[3]`.
    pub field: String,
    /// What the recording says.
    pub recorded: String,
    /// What happens.
    pub simulated: String,
}

/// Plays an episode again from its seed and its actions, and compares every message.
///
/// Who decided, and what the critic expected, cannot be proved: they are taken from the recording.
pub fn verify<const N: usize, E: Simulated<N>>(
    player: &mut Player<E, N>,
    recorded: &Recorded,
) -> Result<Option<Difference>, PlayError> {
    let begin = recorded.messages.first().map_or(0, |sent| sent.time);
    let simulated = player.messages(&recorded.script, begin)?;
    // A whole episode has as many messages as its number of steps asks for.
    debug_assert_eq!(recorded.messages.len(), simulated.len());
    let pairs = || {
        let mut step = 0;
        recorded.messages.iter().zip(&simulated).map(move |(sent, Timed { time, message })| {
            step += usize::from(sent.topic == Topic::Transforms && sent.time > begin);
            let simulated = Sent { time: *time, topic: message.topic(), bytes: message.to_bytes() };
            (step, sent, simulated)
        })
    };
    // Numbers before pictures: marks of hindsight show the end of an episode from its beginning.
    let numbers = pairs().filter(|(_, sent, _)| sent.topic.encoding() == "json");
    let different = numbers.chain(pairs()).find_map(|(step, sent, simulated)| {
        let (field, in_recording, simulated) = first_difference(sent, &simulated)?;
        let episode = recorded.script.number;
        Some(Difference { episode, step, field, recorded: in_recording, simulated })
    });
    Ok(different)
}

/// What differs between two messages, and how it is in each.
fn first_difference(recorded: &Sent, simulated: &Sent) -> Option<(String, String, String)> {
    let topic = recorded.topic.name();
    if recorded == simulated {
        return None;
    }
    if recorded.topic != simulated.topic {
        let other = simulated.topic.name();
        return Some(("topic".to_owned(), topic.to_owned(), other.to_owned()));
    }
    if recorded.time != simulated.time {
        let time = |sent: &Sent| format!("{} ns", sent.time);
        return Some((format!("{topic} time"), time(recorded), time(simulated)));
    }
    // Other bytes may say the same: names in another order.
    let [a, b] = [recorded, simulated].map(fields);
    let (field, a, b) = match (a, b) {
        (Some(a), Some(b)) => differing(String::new(), &a, &b)?,
        _ => ("message".to_owned(), "unreadable".to_owned(), "readable".to_owned()),
    };
    Some((format!("{topic} {field}"), a, b))
}

/// A message as a tree of named values.
fn fields(sent: &Sent) -> Option<Value> {
    match sent.topic {
        Topic::Transforms => {
            let message = FrameTransforms::decode(&*sent.bytes).ok()?;
            let transforms = message.transforms.into_iter().map(|transform| {
                let (child, parent) = (transform.child_frame_id, transform.parent_frame_id);
                let v = transform.translation.unwrap_or_default();
                let r = transform.rotation.unwrap_or_default();
                let time = transform.timestamp.map(|time| time.total_nanos());
                let value = serde_json::json!({
                    "parent": parent,
                    "timestamp": time,
                    "translation": { "x": v.x, "y": v.y, "z": v.z },
                    "rotation": { "x": r.x, "y": r.y, "z": r.z, "w": r.w },
                });
                (child, value)
            });
            Some(Value::Object(transforms.collect()))
        }
        Topic::Scene => {
            let message = SceneUpdate::decode(&*sent.bytes).ok()?;
            let entities = message
                .entities
                .into_iter()
                .map(|entity| (entity.id.clone(), format!("{entity:?}").into()));
            Some(Value::Object(entities.collect()))
        }
        Topic::Begin | Topic::Frame | Topic::Action => serde_json::from_slice(&sent.bytes).ok(),
    }
}

/// The first place where two trees differ, and what is there.
fn differing(path: String, a: &Value, b: &Value) -> Option<(String, String, String)> {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            keys.into_iter().find_map(|key| {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let at = |object: &serde_json::Map<String, Value>| {
                    object.get(key).cloned().unwrap_or(Value::Null)
                };
                differing(path, &at(a), &at(b))
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => a
            .iter()
            .zip(b)
            .enumerate()
            .find_map(|(index, (a, b))| differing(format!("{path}[{index}]"), a, b)),
        // As text: −0 is not 0.
        (a, b) => {
            let (a, b) = (a.to_string(), b.to_string());
            (a != b).then_some((path, a, b))
        }
    }
}
