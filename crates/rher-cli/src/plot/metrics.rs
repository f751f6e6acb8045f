//! Everything that evaluations say besides success, as quantities that can be drawn.

use super::chart::Look;
use super::looks::{self, Looks};
use super::success::subtask_name;
use super::view::{Quantity, Series, Unit};
use rher_runs::{Group, MetricsError, Run, read_metrics};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Keys that belong together, what they are called, and their unit.
const KNOWN: [(&str, Unit, &[&str]); 14] = [
    ("training episodes that were solved", Unit::Share, &["train_success"]),
    ("final distance to the targets, m", Unit::Number, &["final_distance"]),
    ("sub-task that guides", Unit::Number, &["guide"]),
    ("who chose the actions", Unit::Share, &["acted"]),
    ("training episodes that moved", Unit::Share, &["moved"]),
    ("batches with one reward", Unit::Share, &["single_reward"]),
    ("critic loss", Unit::Number, &["critic_loss"]),
    ("actor loss", Unit::Number, &["actor_loss"]),
    ("Q over batches", Unit::Number, &["q_mean", "q_min", "q_max"]),
    ("norms of gradients", Unit::Number, &["critic_gradient", "actor_gradient"]),
    ("training episodes", Unit::Number, &["episodes"]),
    ("updates of the critics", Unit::Number, &["updates"]),
    ("wall clock, s", Unit::Number, &["wall_s"]),
    ("seconds spent on", Unit::Number, &["time"]),
];

/// What the curves of success show, and the horizontal axis.
const ELSEWHERE: [&str; 3] = ["success", "success_final", "env_steps"];

/// The metrics of runs, by folder.
type Metrics = Rc<BTreeMap<PathBuf, Vec<Map<String, Value>>>>;

/// A number, one of a list, or one of a table.
#[derive(Clone)]
enum Inner {
    Whole,
    Item(usize),
    Field(String),
}

/// Every quantity in the metrics of runs of one task; those that are not known here come last.
pub(crate) fn quantities(groups: &[(Group, Vec<Run>)]) -> Result<Vec<Quantity>, MetricsError> {
    let runs = groups.iter().flat_map(|(_, runs)| runs);
    let read = |run: &Run| Ok((run.folder.clone(), read_metrics(&run.folder, run.id)?));
    let metrics: Metrics = Rc::new(runs.map(read).collect::<Result<_, MetricsError>>()?);
    let mut last: BTreeMap<&str, &Value> = BTreeMap::new();
    for (key, value) in metrics.values().filter_map(|lines| lines.last()).flatten() {
        last.insert(key, value);
    }
    let is_known = |key: &str| KNOWN.iter().any(|(.., keys)| keys.contains(&key));
    let others = last.keys().filter(|key| !is_known(key) && !ELSEWHERE.contains(key));
    let others: Vec<[&str; 1]> = others.map(|key| [*key]).collect();
    let others = others.iter().map(|key| (key[0], Unit::Number, &key[..]));
    let task = &groups[0].0.task;
    let quantity = |(title, unit, keys): (&str, Unit, &[&str])| {
        let parts = keys.iter().filter_map(|key| Some((*key, parts(last.get(key)?))));
        let parts: Vec<(&str, Inner)> =
            parts.flat_map(|(key, inner)| inner.into_iter().map(move |it| (key, it))).collect();
        let names: Vec<String> =
            parts.iter().map(|(key, inner)| part_name(task, key, inner)).collect();
        let looks = Looks::of(names.iter().cloned());
        let series = parts.into_iter().zip(names).map(|((key, inner), name)| {
            let look = match (key, &inner) {
                ("moved", Inner::Item(object)) => looks::object(&name, *object),
                ("single_reward", Inner::Item(index)) => looks::subtask(&name, *index),
                _ => looks.get(&name),
            };
            series(look, &metrics, key, inner)
        });
        Quantity { title: title.to_owned(), unit, series: series.collect() }
    };
    let quantities = KNOWN.into_iter().chain(others).map(quantity);
    Ok(quantities.filter(|quantity| !quantity.series.is_empty()).collect())
}

/// The numbers in a value; none in text.
fn parts(value: &Value) -> Vec<Inner> {
    match value {
        Value::Array(items) => (0..items.len()).map(Inner::Item).collect(),
        Value::Object(fields) => fields.keys().cloned().map(Inner::Field).collect(),
        Value::Number(_) | Value::Null => vec![Inner::Whole],
        Value::Bool(_) | Value::String(_) => Vec::new(),
    }
}

fn part_name(task: &str, key: &str, inner: &Inner) -> String {
    match (key, inner) {
        ("single_reward", Inner::Item(index)) => subtask_name(task, *index),
        ("moved", Inner::Item(index)) => format!("object {}", index + 1),
        (_, Inner::Item(index)) => format!("{key} {}", index + 1),
        (_, Inner::Field(field)) => field.clone(),
        (_, Inner::Whole) => key.replace('_', " "),
    }
}

fn series(look: Look, metrics: &Metrics, key: &str, inner: Inner) -> Series {
    let (metrics, key) = (Rc::clone(metrics), key.to_owned());
    let number = move |line: &Map<String, Value>| {
        let value = line.get(&key)?;
        match &inner {
            Inner::Whole => value.as_f64(),
            Inner::Item(index) => value.get(index)?.as_f64(),
            Inner::Field(field) => value.get(field)?.as_f64(),
        }
    };
    let values = move |run: &Run| {
        let lines = metrics.get::<Path>(&run.folder);
        lines.into_iter().flatten().map(&number).collect()
    };
    Series { look, values: Box::new(values) }
}
