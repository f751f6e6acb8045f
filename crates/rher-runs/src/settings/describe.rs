//! Every setting in words, from its declaration.

use rher_core::config::{Choice, Kind, Section, Setting, TrainConfig};
use rher_envs::{Randomize, Task};
use std::fmt::Write as _;

/// Key of the task's name.
pub(super) const NAME: &str = "task.name";

/// A setting in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Described {
    /// Dotted key, as in `--set`.
    pub key: String,
    /// The whole explanation.
    pub doc: String,
    /// The values that it accepts.
    pub expected: String,
    /// The same by name, if they have names.
    pub choices: &'static [Choice],
    /// The only tasks that have it, if not every task does.
    pub tasks: Vec<Task>,
}

impl Described {
    fn of(setting: &Setting) -> Self {
        let key = if setting.key == "task" { NAME } else { setting.key };
        let choices = match setting.kind {
            Kind::Choice(choices) => choices,
            _ => &[],
        };
        Self {
            key: key.to_owned(),
            doc: join(setting.doc),
            expected: setting.expected(),
            choices,
            tasks: Vec::new(),
        }
    }

    /// The first sentence of the explanation.
    pub fn summary(&self) -> &str {
        let ends = self.doc.match_indices(". ").map(|(end, _)| end);
        let starts_sentence =
            |end: &usize| self.doc[end + 2..].starts_with(|next: char| next.is_uppercase());
        ends.into_iter().find(starts_sentence).map_or(&self.doc, |end| &self.doc[..=end])
    }
}

/// A part of a settings file in words.
pub(super) struct Part {
    pub(super) name: &'static str,
    pub(super) doc: String,
    pub(super) settings: Vec<Described>,
}

/// Every setting in words, in the order of a settings file.
pub(super) fn parts() -> Vec<Part> {
    let part = |Section { name, doc, settings }: &Section| Part {
        name,
        doc: join(doc),
        settings: settings.iter().map(Described::of).collect(),
    };
    let mut parts: Vec<Part> = TrainConfig::SECTIONS.iter().map(part).collect();
    let name = parts[0].settings.iter().position(|setting| setting.key == NAME);
    let name = name.map(|index| parts[0].settings.remove(index));
    let options = Task::ALL.iter().flat_map(|task| task.options().iter().map(|o| (*task, o)));
    let options = options.map(|(task, option)| Described {
        key: format!("task.{}", option.name),
        doc: option.doc.to_owned(),
        expected: option.expected(),
        choices: &[],
        tasks: vec![task],
    });
    let task = Part {
        name: "task",
        doc: "The task, and settings that only this task has.".to_owned(),
        settings: name.into_iter().chain(options).collect(),
    };
    let randomize = Part {
        name: "randomize",
        doc: join(Randomize::DOC),
        settings: Randomize::SETTINGS
            .iter()
            .map(|setting| Described {
                key: format!("randomize.{}", setting.name),
                doc: join(setting.doc),
                expected: setting.expected(),
                choices: &[],
                tasks: Vec::new(),
            })
            .collect(),
    };
    parts.splice(1..1, [task, randomize]);
    parts
}

/// The setting with this dotted key, if there is one.
pub fn described(key: &str) -> Option<Described> {
    parts().into_iter().flat_map(|part| part.settings).find(|setting| setting.key == key)
}

/// The values that the setting with this dotted key accepts.
pub(super) fn expected(key: &str) -> Option<String> {
    described(key).map(|setting| setting.expected)
}

/// The explanation of a section.
pub(super) fn section_doc(name: &str) -> String {
    parts().into_iter().find(|part| part.name == name).map(|part| part.doc).unwrap_or_default()
}

/// Every setting with one line about it.
pub fn list() -> String {
    let mut text = "Every setting, as in `--set KEY=VALUE`; `rher config <TASK> --explain` \
                    explains them with their values.\n"
        .to_owned();
    for part in parts() {
        text.push('\n');
        for setting in part.settings {
            let tasks: Vec<_> = setting.tasks.iter().map(|task| task.name()).collect();
            let only = match tasks.as_slice() {
                [] => String::new(),
                tasks => format!(" (only `{}`)", tasks.join("`, `")),
            };
            let Described { key, .. } = &setting;
            // Writing to a string does not fail.
            let _ = writeln!(text, "  {key:<32} {}{only}", setting.summary());
        }
    }
    text
}

/// Lines of documentation as one text.
pub(super) fn join(lines: &[&str]) -> String {
    let lines: Vec<_> =
        lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty()).collect();
    lines.join(" ")
}

/// Cuts a text into lines of at most `width` characters, if its words are not longer.
pub(super) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
