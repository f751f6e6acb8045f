//! What the numbers of an observation are called, and their units.

use super::sink::{Sink, Subject};
use nalgebra::Vector3;
use rher_core::goal::Position;

/// A [`Sink`] that learns what each number is called and what it measures.
pub(crate) struct Labels<'a> {
    objects: &'a [String],
    now: Subject,
    list: Vec<String>,
    units: Vec<&'static str>,
}

impl<'a> Labels<'a> {
    /// With the names of the objects, in relay order.
    pub(crate) fn new(objects: &'a [String]) -> Self {
        Self { objects, now: Subject::Gripper, list: Vec::new(), units: Vec::new() }
    }

    /// One name for each number of the observation; from the second on, numbers that are there
    /// several times have a count behind their name.
    pub(crate) fn into_names(self) -> Vec<String> {
        let Self { list, .. } = self;
        let count = |(index, label): (usize, &String)| match list[..=index]
            .iter()
            .filter(|other| *other == label)
            .count()
        {
            1 => label.clone(),
            count => format!("{label}#{count}"),
        };
        list.iter().enumerate().map(count).collect()
    }

    /// The unit of each number.
    pub(crate) fn units(&self) -> Vec<String> {
        self.units.iter().map(|unit| (*unit).to_owned()).collect()
    }

    fn add(&mut self, subject: Subject, what: &str, unit: &'static str) {
        let label = match subject {
            Subject::Gripper => format!("gripper.{what}"),
            Subject::Object(object) => format!("{}.{what}", self.objects[object]),
            Subject::Between(one, other) => {
                format!("{}.{what}_{}", self.objects[one], self.objects[other])
            }
            Subject::Scenery(name) => format!("{name}.{what}"),
        };
        self.list.extend(["x", "y", "z"].map(|axis| format!("{label}.{axis}")));
        self.units.extend([unit; 3]);
    }
}

impl Sink for Labels<'_> {
    fn about(&mut self, about: Subject) {
        self.now = about;
    }

    fn gripper(&mut self, _: Position) {
        self.add(Subject::Gripper, "position", "m");
    }

    fn object(&mut self, index: usize, _: Position) {
        self.add(Subject::Object(index), "position", "m");
    }

    fn position(&mut self, what: &str, _: Position) {
        self.add(self.now, what, "m");
    }

    fn vector(&mut self, what: &str, _: Vector3<f32>) {
        let unit = match what {
            "last_action" => "1",
            what if what.ends_with("velocity") => "m/step",
            _ => "m",
        };
        self.add(self.now, what, unit);
    }

    fn turn(&mut self, what: &str, _: Vector3<f32>) {
        self.add(self.now, what, if what == "spin" { "rad/step" } else { "rad" });
    }

    fn fingers(&mut self, what: &str, _: [f32; 2]) {
        self.list.extend(["finger1", "finger2"].map(|finger| format!("{finger}.{what}")));
        self.units.extend([if what.ends_with("velocity") { "m/step" } else { "m" }; 2]);
    }
}
