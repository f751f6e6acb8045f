//! What is known about a setting: its key, its type, its range and its documentation.

use serde::Serialize;
use std::fmt;

/// What is known about a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Dotted key, as in `--set`.
    pub key: &'static str,
    /// Lines of its documentation; the first sentence can stand alone.
    pub doc: &'static [&'static str],
    /// Type of its value.
    pub kind: Kind,
    /// Range of its value.
    pub range: Range,
}

impl Setting {
    /// The values that it accepts, in words.
    pub fn expected(&self) -> String {
        match (self.kind, self.range) {
            (Kind::Text, _) => "text in quotes".to_owned(),
            (Kind::Flag, _) => "true or false".to_owned(),
            (Kind::Number, Range::Any) => "a number".to_owned(),
            (Kind::Number, range) => format!("a number {range}"),
            (Kind::Whole, Range::Any) => "a whole number of at least 0".to_owned(),
            (Kind::Whole, range) => format!("a whole number {range}"),
            (Kind::Widths, range) => {
                format!("a list of 1 to {MOST_LAYERS} whole numbers in brackets, each {range}")
            }
            (Kind::Choice(choices), _) => {
                let names: Vec<_> =
                    choices.iter().map(|choice| format!("`{}`", choice.name)).collect();
                match names.split_last() {
                    Some((last, [])) => last.clone(),
                    Some((last, others)) => format!("{} or {last}", others.join(", ")),
                    None => String::new(),
                }
            }
        }
    }
}

/// A part of a settings file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Name in brackets; empty for the settings before the first section.
    pub name: &'static str,
    /// Lines of its documentation.
    pub doc: &'static [&'static str],
    /// Its settings, in the order of the file.
    pub settings: &'static [Setting],
}

/// Type of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Text in quotes.
    Text,
    /// True or false.
    Flag,
    /// Any number.
    Number,
    /// A whole number.
    Whole,
    /// Widths of layers.
    Widths,
    /// One of a few names.
    Choice(&'static [Choice]),
}

/// One value of a setting that has one of a few.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Name in files and on the command line.
    pub name: &'static str,
    /// Lines of its documentation.
    pub doc: &'static [&'static str],
}

/// Range of a number, or of each number in a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Every value of the type.
    Any,
    /// 0 to 1, both included.
    Share,
    /// Above 0 and at most 1.
    PositiveShare,
    /// At least 0 and below 1.
    ShareBelowOne,
    /// Above 0.
    Positive,
    /// At least 0.
    NonNegative,
    /// At least this.
    AtLeast(u64),
    /// Between two whole numbers, both included.
    Between(u64, u64),
}

impl Range {
    /// Every whole number that TOML can write down.
    pub const TOML: Self = Self::Between(0, i64::MAX as u64);

    fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Share => (0.0..=1.0).contains(&value),
                Self::PositiveShare => value > 0.0 && value <= 1.0,
                Self::ShareBelowOne => (0.0..1.0).contains(&value),
                Self::Positive => value > 0.0,
                Self::NonNegative => value >= 0.0,
                Self::AtLeast(least) => value >= least as f64,
                Self::Between(least, most) => (least as f64..=most as f64).contains(&value),
            }
    }

    fn contains_whole(self, value: u64) -> bool {
        match self {
            Self::Between(least, most) => (least..=most).contains(&value),
            range => i64::try_from(value).is_ok() && range.contains(value as f64),
        }
    }
}

/// As the end of "a number …".
impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("of any size"),
            Self::Share => f.write_str("from 0 to 1"),
            Self::PositiveShare => f.write_str("above 0 and at most 1"),
            Self::ShareBelowOne => f.write_str("of at least 0 and below 1"),
            Self::Positive => f.write_str("above 0"),
            Self::NonNegative => f.write_str("of at least 0"),
            Self::AtLeast(least) => write!(f, "of at least {least}"),
            Self::Between(least, most) => write!(f, "from {least} to {most}"),
        }
    }
}

/// Most hidden layers of a network.
const MOST_LAYERS: usize = 64;

/// A type that a setting can have.
pub trait Value: fmt::Debug + Serialize {
    /// The same type, as data.
    const KIND: Kind;

    /// Whether the value is in `range`.
    fn fits(&self, range: Range) -> bool;
}

impl Value for String {
    const KIND: Kind = Kind::Text;

    fn fits(&self, _: Range) -> bool {
        true
    }
}

impl Value for bool {
    const KIND: Kind = Kind::Flag;

    fn fits(&self, _: Range) -> bool {
        true
    }
}

impl Value for f32 {
    const KIND: Kind = Kind::Number;

    fn fits(&self, range: Range) -> bool {
        range.contains(f64::from(*self))
    }
}

impl Value for u32 {
    const KIND: Kind = Kind::Whole;

    fn fits(&self, range: Range) -> bool {
        range.contains_whole(u64::from(*self))
    }
}

impl Value for u64 {
    const KIND: Kind = Kind::Whole;

    fn fits(&self, range: Range) -> bool {
        range.contains_whole(*self)
    }
}

impl Value for usize {
    const KIND: Kind = Kind::Whole;

    fn fits(&self, range: Range) -> bool {
        range.contains_whole(*self as u64)
    }
}

impl Value for Vec<usize> {
    const KIND: Kind = Kind::Widths;

    fn fits(&self, range: Range) -> bool {
        (1..=MOST_LAYERS).contains(&self.len()) && self.iter().all(|width| width.fits(range))
    }
}

/// Looks at settings and their values, one after the other.
pub trait SettingVisitor {
    /// What can go wrong.
    type Error;

    /// Looks at a setting and its value.
    fn visit<T: Value>(&mut self, setting: &'static Setting, value: &T) -> Result<(), Self::Error>;
}
