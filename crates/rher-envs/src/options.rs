//! What can be set about the environments of a task.

use rand::{Rng, RngExt as _};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// Settings of the environments of a task.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// The task's own.
    pub task: TaskOptions,
    /// What is drawn anew for every episode.
    pub randomize: Randomize,
}

impl Options {
    /// The options of a task that has `known` ones of its own, each at its default.
    #[must_use]
    pub fn of(known: &[TaskOption]) -> Self {
        Self { task: TaskOptions::defaults(known), randomize: Randomize::default() }
    }

    /// Checks every name, type and range, and fills in the defaults of a task with these `known`
    /// options.
    pub fn check(&self, known: &[TaskOption]) -> Result<Self, OptionError> {
        self.randomize.check()?;
        Ok(Self { task: self.task.check(known)?, randomize: self.randomize.clone() })
    }
}

/// As JSON, on one line.
impl fmt::Display for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&serde_json::to_string(self).map_err(|_| fmt::Error)?)
    }
}

impl FromStr for Options {
    type Err = serde_json::Error;

    fn from_str(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }
}

/// What one task, and no other, lets be set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskOption {
    /// Name in files and on the command line, after `task.`.
    pub name: &'static str,
    /// What it is unless it is set.
    pub default: OptionValue,
    /// The largest number that it can be set to; the smallest is 0.
    pub largest: f32,
}

impl TaskOption {
    /// Something that is so or is not.
    pub const fn flag(name: &'static str, default: bool) -> Self {
        Self { name, default: OptionValue::Flag(default), largest: 0.0 }
    }

    /// A number from 0 to `largest`.
    pub const fn number(name: &'static str, default: f32, largest: f32) -> Self {
        Self { name, default: OptionValue::Number(default), largest }
    }

    /// A whole number from 0 to `largest`.
    pub const fn count(name: &'static str, default: u32, largest: u32) -> Self {
        Self { name, default: OptionValue::Count(default), largest: largest as f32 }
    }

    /// `value` as this option has it, if it can have it.
    fn accept(&self, value: OptionValue) -> Option<OptionValue> {
        let value = match (self.default, value) {
            (OptionValue::Number(_), OptionValue::Count(count)) => {
                OptionValue::Number(count as f32)
            }
            (_, value) => value,
        };
        let fits = match (self.default, value) {
            (OptionValue::Flag(_), OptionValue::Flag(_)) => true,
            (OptionValue::Count(_), OptionValue::Count(count)) => count as f32 <= self.largest,
            (OptionValue::Number(_), OptionValue::Number(number)) => {
                (0.0..=self.largest).contains(&number)
            }
            _ => false,
        };
        fits.then_some(value)
    }

    fn allowed(&self) -> String {
        match self.default {
            OptionValue::Flag(_) => "true or false".to_owned(),
            OptionValue::Count(_) => format!("a whole number from 0 to {}", self.largest),
            OptionValue::Number(_) => format!("a number from 0 to {}", self.largest),
        }
    }
}

/// What a [`TaskOption`] is set to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum OptionValue {
    /// So, or not.
    Flag(bool),
    /// A whole number.
    Count(u32),
    /// Any number.
    Number(f32),
}

impl fmt::Display for OptionValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => flag.fmt(f),
            Self::Count(count) => count.fmt(f),
            Self::Number(number) => number.fmt(f),
        }
    }
}

impl<'de> Deserialize<'de> for OptionValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AnyValue;

        impl Visitor<'_> for AnyValue {
            type Value = OptionValue;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("true, false or a number")
            }

            fn visit_bool<E: Error>(self, flag: bool) -> Result<OptionValue, E> {
                Ok(OptionValue::Flag(flag))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<OptionValue, E> {
                let count = u32::try_from(number).map(OptionValue::Count);
                Ok(count.unwrap_or(OptionValue::Number(number as f32)))
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<OptionValue, E> {
                let count = u32::try_from(number).map(OptionValue::Count);
                Ok(count.unwrap_or(OptionValue::Number(number as f32)))
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<OptionValue, E> {
                Ok(OptionValue::Number(number as f32))
            }
        }

        deserializer.deserialize_any(AnyValue)
    }
}

/// Values of a task's own options, by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct TaskOptions(pub BTreeMap<String, OptionValue>);

impl TaskOptions {
    /// Every option with its default.
    #[must_use]
    pub fn defaults(options: &[TaskOption]) -> Self {
        Self(options.iter().map(|option| (option.name.to_owned(), option.default)).collect())
    }

    /// Whether `option` is set, or is so by default.
    pub fn flag(&self, option: &TaskOption) -> bool {
        self.value(option) == OptionValue::Flag(true)
    }

    /// The number that `option` is set to, or its default.
    pub fn number(&self, option: &TaskOption) -> f32 {
        match self.value(option) {
            OptionValue::Flag(flag) => f32::from(u8::from(flag)),
            OptionValue::Count(count) => count as f32,
            OptionValue::Number(number) => number,
        }
    }

    fn value(&self, option: &TaskOption) -> OptionValue {
        self.0.get(option.name).copied().unwrap_or(option.default)
    }

    /// Checks names, types and ranges, and fills in the defaults.
    fn check(&self, known: &[TaskOption]) -> Result<Self, OptionError> {
        let mut checked = Self::defaults(known);
        for (name, value) in &self.0 {
            let key = format!("task.{name}");
            let Some(option) = known.iter().find(|option| option.name == name) else {
                return Err(OptionError::Unknown { key });
            };
            let Some(value) = option.accept(*value) else {
                let (value, allowed) = (value.to_string(), option.allowed());
                return Err(OptionError::OutOfRange { key, value, allowed });
            };
            checked.0.insert(name.clone(), value);
        }
        Ok(checked)
    }
}

/// What is drawn anew for every episode, each uniformly from a range; by default from none.
///
/// Draws come from the seed of the episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Randomize {
    /// Factor on every coefficient of friction, one for the whole scene: 0.2 to 3.
    pub friction: [f32; 2],
    /// Factor on the mass of what can be moved freely, one for each object: 0.2 to 5.
    pub mass: [f32; 2],
    /// Factor on its size: 0.8 to 1.2.
    pub size: [f32; 2],
    /// Standard deviation of the noise on where it is seen, in metres: 0 to 0.05.
    pub sensor_noise: [f32; 2],
    /// Steps by which actions are late: 0 to 5.
    pub action_delay: [u32; 2],
}

impl Default for Randomize {
    fn default() -> Self {
        Self {
            friction: [1.0; 2],
            mass: [1.0; 2],
            size: [1.0; 2],
            sensor_noise: [0.0; 2],
            action_delay: [0; 2],
        }
    }
}

impl Randomize {
    /// The longest delay of actions, in steps.
    pub(crate) const LONGEST_DELAY: usize = 5;

    fn check(&self) -> Result<(), OptionError> {
        let Self { friction, mass, size, sensor_noise, action_delay } = self;
        let [low, high] = *action_delay;
        let whole = [low as f32, high as f32];
        for (name, [low, high], [least, most]) in [
            ("friction", *friction, [0.2, 3.0]),
            ("mass", *mass, [0.2, 5.0]),
            ("size", *size, [0.8, 1.2]),
            ("sensor_noise", *sensor_noise, [0.0, 0.05]),
            ("action_delay", whole, [0.0, Self::LONGEST_DELAY as f32]),
        ] {
            if !(least <= low && low <= high && high <= most) {
                return Err(OptionError::OutOfRange {
                    key: format!("randomize.{name}"),
                    value: format!("[{low}, {high}]"),
                    allowed: format!("[low, high] with {least} ≤ low ≤ high ≤ {most}"),
                });
            }
        }
        Ok(())
    }
}

/// A number of a range, which may be a single one.
pub(crate) fn draw([low, high]: [f32; 2], rng: &mut impl Rng) -> f32 {
    let share: f32 = rng.random();
    low + share * (high - low)
}

/// Options do not fit a task.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OptionError {
    /// The task has no such option.
    #[error("there is no setting `{key}`")]
    Unknown {
        /// Dotted name.
        key: String,
    },
    /// The value has another type, or is outside its range.
    #[error("`{key}` is {value}, expected {allowed}")]
    OutOfRange {
        /// Dotted name.
        key: String,
        /// What it is.
        value: String,
        /// What it may be.
        allowed: String,
    },
}

impl OptionError {
    /// Dotted name of the setting that is wrong.
    pub fn key(&self) -> &str {
        match self {
            Self::Unknown { key } | Self::OutOfRange { key, .. } => key,
        }
    }
}
