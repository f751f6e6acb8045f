//! Settings of the environments of a task.

use rand::{Rng, RngExt as _};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

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

    /// Those of an environment that has none.
    pub fn none() -> &'static Self {
        static NONE: LazyLock<Options> = LazyLock::new(Options::default);
        &NONE
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

/// A setting that one task has and no other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskOption {
    /// Name in files and on the command line, after `task.`.
    pub name: &'static str,
    /// Its documentation; the first sentence can stand alone.
    pub doc: &'static str,
    /// Value unless it is set.
    pub default: OptionValue,
    /// The largest number that it can be set to; the smallest is 0.
    pub largest: f32,
}

impl TaskOption {
    /// A boolean option.
    pub const fn flag(name: &'static str, default: bool, doc: &'static str) -> Self {
        Self { name, doc, default: OptionValue::Flag(default), largest: 0.0 }
    }

    /// A number from 0 to `largest`.
    pub const fn number(name: &'static str, default: f32, largest: f32, doc: &'static str) -> Self {
        Self { name, doc, default: OptionValue::Number(default), largest }
    }

    /// A whole number from 0 to `largest`.
    pub const fn count(name: &'static str, default: u32, largest: u32, doc: &'static str) -> Self {
        Self { name, doc, default: OptionValue::Count(default), largest: largest as f32 }
    }

    /// `value` in the type of this option, if it is in its range.
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

    /// The values that it accepts, in words.
    pub fn expected(&self) -> String {
        match self.default {
            OptionValue::Flag(_) => "true or false".to_owned(),
            OptionValue::Count(_) => format!("a whole number from 0 to {}", self.largest),
            OptionValue::Number(_) => format!("a number from 0 to {}", self.largest),
        }
    }
}

/// Value of a [`TaskOption`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum OptionValue {
    /// True or false.
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

    /// Whether the boolean `option` is true, by setting or by default.
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
                let (value, expected) = (value.to_string(), option.expected());
                return Err(OptionError::OutOfRange { key, value, expected });
            };
            checked.0.insert(name.clone(), value);
        }
        Ok(checked)
    }
}

/// What is known about a setting of [`Randomize`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomizeSetting {
    /// Name in files and on the command line, after `randomize.`.
    pub name: &'static str,
    /// Lines of its documentation; the first sentence can stand alone.
    pub doc: &'static [&'static str],
    /// Smallest and largest number of a range.
    pub bounds: [f32; 2],
}

impl RandomizeSetting {
    /// The values that it accepts, in words.
    pub fn expected(&self) -> String {
        let [least, most] = self.bounds;
        format!("[low, high] with {least} ≤ low ≤ high ≤ {most}")
    }

    fn check(&self, [low, high]: [f32; 2]) -> Result<(), OptionError> {
        let [least, most] = self.bounds;
        if least <= low && low <= high && high <= most {
            return Ok(());
        }
        Err(OptionError::OutOfRange {
            key: format!("randomize.{}", self.name),
            value: format!("[{low}, {high}]"),
            expected: self.expected(),
        })
    }
}

/// Declares what can be drawn anew for every episode: documentation, type, the value that changes
/// nothing, and bounds.
macro_rules! randomize {
    (
        $(#[doc = $about:literal])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])*
                pub $field:ident: [$number:ty; 2] = $none:literal in $least:literal, $most:expr;
            )+
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $($(#[doc = $doc])* pub $field: [$number; 2],)+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: [$none; 2],)+ }
            }
        }

        impl $name {
            /// Lines of its documentation.
            pub const DOC: &'static [&'static str] = &[$($about),*];

            /// Its settings, in the order of a settings file.
            pub const SETTINGS: &'static [RandomizeSetting] = &[
                $(RandomizeSetting {
                    name: stringify!($field),
                    doc: &[$($doc),*],
                    bounds: [$least as f32, $most as f32],
                },)+
            ];

            /// Checks that nothing is randomized, for an environment that cannot.
            pub(crate) fn check_unset(&self) -> Result<(), OptionError> {
                $(if self.$field != [$none; 2] {
                    return Err(OptionError::OutOfRange {
                        key: concat!("randomize.", stringify!($field)).to_owned(),
                        value: format!("{:?}", self.$field),
                        expected: format!(
                            "{:?}: environments of this task randomize nothing",
                            [$none as $number; 2],
                        ),
                    });
                })+
                Ok(())
            }

            fn check(&self) -> Result<(), OptionError> {
                let ranges = [$(self.$field.map(|bound| bound as f32)),+];
                Self::SETTINGS.iter().zip(ranges).try_for_each(|(setting, range)| {
                    setting.check(range)
                })
            }
        }
    };
}

randomize! {
    /// Domain randomization: values that are drawn for every episode, each uniformly from a range.
    ///
    /// A range is `[low, high]`; by default nothing is randomized. Draws are a function of the seed
    /// of the episode.
    pub struct Randomize {
        /// Factor on every coefficient of friction, one for the whole scene.
        pub friction: [f32; 2] = 1.0 in 0.2, 3.0;
        /// Factor on the mass of each object that can move freely, drawn for each object.
        pub mass: [f32; 2] = 1.0 in 0.2, 5.0;
        /// Factor on the size of each object that can move freely, drawn for each object.
        pub size: [f32; 2] = 1.0 in 0.8, 1.2;
        /// Standard deviation in meters of the Gaussian noise on observed positions.
        pub sensor_noise: [f32; 2] = 0.0 in 0.0, 0.05;
        /// Delay of actions in environment steps.
        pub action_delay: [u32; 2] = 0 in 0, LONGEST_DELAY;
    }
}

/// The longest delay of actions, in steps.
const LONGEST_DELAY: usize = 5;

impl Randomize {
    /// The longest delay of actions, in steps.
    pub(crate) const LONGEST_DELAY: usize = LONGEST_DELAY;
}

/// Draws a number uniformly from a range, which may be a single number.
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
    #[error("`{key}` is {value}, expected {expected}")]
    OutOfRange {
        /// Dotted name.
        key: String,
        /// Its value.
        value: String,
        /// The values that it accepts.
        expected: String,
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
