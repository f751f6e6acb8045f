//! What the values of options are, and how they are read.

use clap::ValueEnum;
use clap::builder::{
    PathBufValueParser, PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser,
    ValueParser,
};
use rher_core::config::{EngineKind, Kind, Method, Precision, Preset, Value};
use rher_envs::Task;
use std::ffi::OsStr;
use std::marker::PhantomData;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ExperimentName {
    /// Table I: which policy acts before the object is reached, in training and in evaluation
    Policies,
    /// The distance that counts as reached: d of 0 to 12 cm
    ReachDistance,
    /// The probability that the guide acts: α of 0 to 0.8
    GuideRate,
    /// One environment against 19 side by side
    Envs,
    /// Plain hindsight, with as many updates as the relay, and with half of them
    Her,
    /// Whether reaching is forgotten while pushing is learned
    Forgetting,
    /// Table II: steps to 95 % on push and pick
    Table2,
    /// The policies that ship with the program, one for each task, with their cards
    Shipped,
}

impl ExperimentName {
    /// As on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Policies => "policies",
            Self::ReachDistance => "reach-distance",
            Self::GuideRate => "guide-rate",
            Self::Envs => "envs",
            Self::Her => "her",
            Self::Forgetting => "forgetting",
            Self::Table2 => "table2",
            Self::Shipped => "shipped",
        }
    }
}

/// One `KEY=VALUE` of `--set`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assignment {
    pub(crate) key: String,
    pub(crate) value: toml::Value,
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or("expected KEY=VALUE, as in `--set agent.discount=0.98`")?;
        Ok(Self { key: key.trim().to_owned(), value: toml_value(value.trim())? })
    }
}

/// Reads the settings of `--set`; `help` prints the list of settings instead.
#[derive(Clone)]
pub(crate) struct OrHelp<T>(PhantomData<T>);

pub(crate) const fn or_help<T>() -> OrHelp<T> {
    OrHelp(PhantomData)
}

impl<T> TypedValueParser for OrHelp<T>
where
    T: FromStr<Err = String> + Clone + Send + Sync + 'static,
{
    type Value = T;

    fn parse_ref(
        &self,
        command: &clap::Command,
        arg: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<T, clap::Error> {
        if value == "help" {
            // An error that is made by hand would be printed as one.
            let list = clap::Command::new("help").override_help(rher_runs::settings::list());
            let help = list.try_get_matches_from(["help", "--help"]);
            return Err(help.expect_err("it is asked for help"));
        }
        let parser = StringValueParser::new().try_map(|text| text.parse::<T>());
        parser.parse_ref(command, arg, value)
    }
}

/// One `KEY=VALUE,…` of `rher sweep --set`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    pub(crate) key: String,
    pub(crate) values: Vec<toml::Value>,
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, values) = text
            .split_once('=')
            .ok_or("expected KEY=VALUE,..., as in `--set relay.mirror=0,0.5`")?;
        let mut depth = 0_i32;
        let separated = values.split(|c| {
            depth += i32::from(c == '[') - i32::from(c == ']');
            c == ',' && depth == 0
        });
        let values = separated.map(|value| toml_value(value.trim())).collect::<Result<_, _>>()?;
        Ok(Self { key: key.trim().to_owned(), values })
    }
}

/// Seeds as in `1-3,7`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seeds(pub(crate) Vec<u64>);

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected seeds as in `1-5` or `1,2,7`".to_owned();
        let mut seeds = Vec::new();
        for part in text.split(',') {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let first: u64 = first.trim().parse().map_err(|_| wrong())?;
            let last: u64 = last.trim().parse().map_err(|_| wrong())?;
            if first > last || last - first >= 1000 {
                return Err(wrong());
            }
            seeds.extend((first..=last).filter(|seed| !seeds.contains(seed)).collect::<Vec<_>>());
        }
        Ok(Self(seeds))
    }
}

/// TOML, but a bare word needs no quotes.
fn toml_value(text: &str) -> Result<toml::Value, String> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    match toml::de::ValueDeserializer::parse(text).and_then(serde::Deserialize::deserialize) {
        Ok(value) => Ok(value),
        Err(_) if !text.is_empty() && text.chars().all(is_word) => Ok(text.into()),
        Err(error) => Err(format!("`{text}` is not a TOML value: {}", error.message())),
    }
}

pub(crate) fn preset() -> ValueParser {
    named(Preset::ALL, Preset::name)
}

pub(crate) fn method() -> ValueParser {
    named(Method::ALL, Method::name)
}

pub(crate) fn engine() -> ValueParser {
    named(EngineKind::AVAILABLE, EngineKind::name)
}

pub(crate) fn precision() -> ValueParser {
    named(Precision::ALL, Precision::name)
}

/// Takes the name of one of `all`, whose help is the first paragraph of its documentation.
fn named<T>(all: &'static [T], name: fn(T) -> &'static str) -> ValueParser
where
    T: Value + Copy + Send + Sync + 'static,
{
    let choices = match T::KIND {
        Kind::Choice(choices) => choices,
        _ => &[],
    };
    let possible = all.iter().map(|&value| {
        let choice = choices.iter().find(|choice| choice.name == name(value));
        let lines = choice.map_or(&[][..], |choice| choice.doc);
        let paragraph: Vec<_> =
            lines.iter().map(|line| line.trim()).take_while(|line| !line.is_empty()).collect();
        PossibleValue::new(name(value)).help(paragraph.join(" ").trim_end_matches('.').to_owned())
    });
    ValueParser::new(PossibleValuesParser::new(possible).try_map(move |chosen| {
        let found = all.iter().copied().find(|&value| name(value) == chosen);
        found.ok_or("there is no such value")
    }))
}

pub(crate) fn task() -> ValueParser {
    ValueParser::new(TaskName)
}

/// Reads the name of a task, or the identity of its Gymnasium environment or of that of which it has
/// the conventions.
#[derive(Clone)]
struct TaskName;

impl TaskName {
    fn names() -> PossibleValuesParser {
        PossibleValuesParser::new(Task::all().into_iter().map(Task::name))
    }
}

impl TypedValueParser for TaskName {
    type Value = Task;

    fn parse_ref(
        &self,
        command: &clap::Command,
        arg: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<Task, clap::Error> {
        if let Some(task) = value.to_str().and_then(task_of_gymnasium) {
            return Ok(task);
        }
        Self::names().try_map(|name| name.parse::<Task>()).parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(Task::all().into_iter().map(|task| PossibleValue::new(task.name()))))
    }
}

/// The task of this name, or of this Gymnasium environment.
pub(crate) fn task_named(name: &str) -> Option<Task> {
    name.parse().ok().or_else(|| task_of_gymnasium(name))
}

/// The task of an environment such as `rher/Push-v0` or `FetchPush-v4`, of any version.
fn task_of_gymnasium(id: &str) -> Option<Task> {
    let (name, version) = id.rsplit_once("-v")?;
    version.parse::<u32>().ok()?;
    let ours = |task: &Task| {
        let id = task.gymnasium_id().and_then(|id| id.rsplit_once("-v"));
        id.is_some_and(|(of, _)| of == name)
    };
    match name {
        "FetchReach" => Some(Task::REACH),
        "FetchPush" => Some(Task::PUSH),
        "FetchSlide" => Some(Task::SLIDE),
        "FetchPickAndPlace" => Some(Task::PICK),
        _ => Task::ALL.iter().copied().find(ours),
    }
}

/// Integers from `least` to the largest that TOML has, also as `100_000`, `100k`, `2M` or `1e5`.
pub(crate) fn toml_integer(least: u64) -> impl Fn(&str) -> Result<u64, String> + Clone {
    move |text| {
        let number = integer(text).filter(|number| (least..=i64::MAX as u64).contains(number));
        number.ok_or_else(|| {
            format!("expected a whole number of at least {least}, as in `100000`, `100k` or `1e5`")
        })
    }
}

fn integer(text: &str) -> Option<u64> {
    let digits = text.replace('_', "");
    let starts = digits.starts_with(|c: char| c.is_ascii_digit());
    let (number, power) = match digits.as_bytes().last()? {
        b'k' => (&digits[..digits.len() - 1], 3),
        b'M' => (&digits[..digits.len() - 1], 6),
        _ => match digits.split_once(['e', 'E']) {
            Some((number, power)) => (number, power.parse().ok()?),
            None => (&*digits, 0),
        },
    };
    // Digits behind the point move it to the right, and have to be gone in the end.
    let (whole, rest) = number.split_once('.').unwrap_or((number, ""));
    let rest = rest.trim_end_matches('0');
    let power = u32::checked_sub(power, u32::try_from(rest.len()).ok()?)?;
    let number: u64 = format!("{whole}{rest}").parse().ok().filter(|_| starts)?;
    number.checked_mul(10_u64.checked_pow(power)?)
}

/// Paths of recordings, by whose end Foxglove knows them.
pub(crate) fn recording() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        let fits = path.extension().is_some_and(|extension| extension == "mcap");
        fits.then_some(path).ok_or("expected a name that ends in `.mcap`")
    })
}

/// Paths of charts.
pub(crate) fn picture() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        let fits =
            path.extension().is_some_and(|extension| extension == "svg" || extension == "png");
        fits.then_some(path).ok_or("expected a name that ends in .svg or .png")
    })
}

/// Numbers of panels beside each other.
pub(crate) fn columns(text: &str) -> Result<NonZeroUsize, String> {
    count(text, 20)
}

/// Numbers of threads.
pub(crate) fn workers(text: &str) -> Result<NonZeroUsize, String> {
    count(text, 1024)
}

/// Numbers of evaluation episodes.
pub(crate) fn episodes(text: &str) -> Result<NonZeroUsize, String> {
    count(text, 1_000_000)
}

fn count(text: &str, most: usize) -> Result<NonZeroUsize, String> {
    let count = text.parse().ok().filter(|count: &NonZeroUsize| count.get() <= most);
    count.ok_or_else(|| format!("expected a whole number from 1 to {most}"))
}

pub(crate) fn rate(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(rate) if (0.0..=1.0).contains(&rate) => Ok(rate),
        _ => Err("expected a number from 0 to 1".to_owned()),
    }
}

/// A time as in `90s`, `55m` or `4h`.
pub(crate) fn time(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a time as in `90s`, `55m` or `4h`".to_owned();
    let unit = match text.chars().next_back() {
        Some('s') => 1.0,
        Some('m') => 60.0,
        Some('h') => 3600.0,
        _ => return Err(wrong()),
    };
    let number: f64 = text[..text.len() - 1].parse().map_err(|_| wrong())?;
    let is_sensible = number > 0.0 && number <= 1e6;
    is_sensible.then(|| Duration::from_secs_f64(number * unit)).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_takes_toml_and_bare_words() {
        let value = |text: &str| text.parse::<Assignment>().unwrap().value;
        assert_eq!(value("a.b=[128, 64]"), toml::Value::from(vec![128, 64]));
        assert_eq!(value("a.b=1e-3"), toml::Value::from(0.001));
        assert_eq!(value("a.b = true"), toml::Value::from(true));
        assert_eq!(value("a.b=sample-efficient"), toml::Value::from("sample-efficient"));
        assert!("a.b=[1".parse::<Assignment>().is_err());
        assert!("a.b".parse::<Assignment>().is_err());
        assert!("a.b=".parse::<Assignment>().is_err());
    }

    #[test]
    fn integers_are_written_as_people_write_them() {
        let at_least_1 = toml_integer(1);
        for text in ["100000", "100_000", "100k", "0.1M", "1e5", "1.0e5", "1E5"] {
            assert_eq!(at_least_1(text), Ok(100_000), "{text}");
        }
        assert_eq!(at_least_1("2.5k"), Ok(2_500));
        assert_eq!(at_least_1("9223372036854775807"), Ok(i64::MAX as u64));
        for wrong in
            ["", "0", "-1", "+1", "k", "1.5", "1e-5", "1e19", "1e99", "1 000", "0x10", "1kk"]
        {
            assert!(at_least_1(wrong).is_err(), "{wrong}");
        }
        assert_eq!(toml_integer(0)("0"), Ok(0));
    }

    #[test]
    fn environments_of_gymnasium_are_tasks() {
        for task in Task::ALL {
            assert_eq!(task.gymnasium_id().and_then(task_of_gymnasium), Some(*task));
        }
        assert_eq!(task_of_gymnasium("FetchPickAndPlace-v4"), Some(Task::PICK));
        for other in ["push", "rher/Push", "FetchPush-vx", "rher/Pull-v0"] {
            assert_eq!(task_of_gymnasium(other), None);
        }
    }

    #[test]
    fn a_time_has_a_unit() {
        assert_eq!(time("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(time("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(time("4h"), Ok(Duration::from_hours(4)));
        for wrong in ["", "90", "m", "-1s", "0s", "nans", "infh", "1d", "1é"] {
            assert!(time(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_sweep_takes_several_values_and_seeds() {
        let axis: Axis = "a.b=[1, 2],[3]".parse().unwrap();
        assert_eq!(axis.values, [toml::Value::from(vec![1, 2]), toml::Value::from(vec![3])]);
        let axis: Axis = "a.b=fan-in,xavier".parse().unwrap();
        assert_eq!(axis.values, [toml::Value::from("fan-in"), toml::Value::from("xavier")]);
        assert_eq!("1-3,7,2".parse(), Ok(Seeds(vec![1, 2, 3, 7])));
        for wrong in ["", "3-1", "a", "1,"] {
            assert!(wrong.parse::<Seeds>().is_err(), "{wrong}");
        }
    }
}
