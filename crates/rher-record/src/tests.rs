use crate::message::{Action, Begin, Frame, Message, Place};
use crate::player::STEP;
use rher_core::explore::ActionSource;
use serde_json::Value;
use std::collections::BTreeSet;

const PLACE: Place = Place { x: 0.1, y: -0.0, z: 3.0e-9 };

fn samples() -> [Message; 3] {
    let begin = Begin {
        episode: 1,
        seed: u64::MAX,
        steps: 2,
        targets: vec![PLACE],
        tolerances: vec![0.05],
        reach_tolerance: 0.05,
    };
    let frame = Frame {
        episode: 1,
        step: 2,
        stage: 1,
        success: true,
        distance: 0.1,
        distances: vec![0.1],
        reward: Some(-1.0),
        sum: -2.0,
        gripper: PLACE,
        objects: vec![PLACE],
        observation: vec![1.0],
    };
    let action = Action {
        episode: 1,
        step: 2,
        action: vec![0.5],
        decider: ActionSource::Guide,
        subtask: 2,
        q: Some(-3.0),
    };
    [Message::Begin(begin), Message::Frame(frame), Message::Action(action)]
}

#[test]
fn schemas_name_every_field_and_no_other() {
    for message in samples() {
        let schema = message.topic().schema();
        let schema: Value = serde_json::from_slice(&schema.data).unwrap();
        let message: Value = serde_json::from_slice(&message.to_bytes()).unwrap();
        let names = |value: &Value| -> BTreeSet<String> {
            value.as_object().unwrap().keys().cloned().collect()
        };
        assert_eq!(names(&schema["properties"]), names(&message), "{}", schema["title"]);
    }
}

#[test]
fn every_bit_of_a_number_comes_back() {
    let [begin, frame, _] = samples();
    let Message::Begin(begin) = begin else { unreachable!() };
    let again: Begin = serde_json::from_slice(&Message::Begin(begin.clone()).to_bytes()).unwrap();
    assert_eq!(again.seed, u64::MAX);
    let again: Frame = serde_json::from_slice(&frame.to_bytes()).unwrap();
    let Place { x, y, z } = again.gripper;
    assert_eq!([x, y, z].map(f32::to_bits), [0.1_f32, -0.0, 3.0e-9].map(f32::to_bits));
}

#[test]
fn a_step_takes_as_long_as_in_the_simulation() {
    assert_eq!(STEP, 40_000_000);
}
