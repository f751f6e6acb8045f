//! What a page says of itself: when, by what and from which runs it was made.

use super::page::Fact;
use crate::cli::ReportArgs;
use chrono::{DateTime, Utc};
use rher_runs::{Group, Machine, Run, is_in_use};
use std::time::SystemTime;

pub(super) fn facts(args: &ReportArgs, groups: &[(Group, Vec<Run>)]) -> Vec<(&'static str, Fact)> {
    let runs: Vec<&Run> = groups.iter().flat_map(|(_, runs)| runs).collect();
    let now = DateTime::<Utc>::from(SystemTime::now());
    let count = format!("{}, in {}", plural(runs.len(), "run"), plural(groups.len(), "group"));
    let mut facts = vec![
        ("date", Fact::Text(now.format("%Y-%m-%d %H:%M UTC").to_string())),
        ("program", Fact::Text(Machine::here().program)),
        ("command", Fact::Code(command(args))),
        ("runs", Fact::Text(count)),
    ];
    let running = runs.iter().filter(|run| is_in_use(&run.folder)).count();
    if running > 0 {
        let verb = if running == 1 { "is" } else { "are" };
        let text = format!("{} {verb} still running and may change", plural(running, "run"));
        facts.push(("state", Fact::Now(text)));
    }
    facts
}

/// The tasks, each once.
pub(super) fn title(groups: &[(Group, Vec<Run>)]) -> String {
    let mut tasks: Vec<&str> = groups.iter().map(|(group, _)| group.task.as_str()).collect();
    tasks.dedup();
    format!("Runs of {}", tasks.join(", "))
}

fn plural(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// What makes this page again.
fn command(args: &ReportArgs) -> String {
    let ReportArgs { runs, out } = args;
    let words = ["rher", "report"].map(str::to_owned).into_iter();
    let words = words.chain(runs.iter().map(|run| run.display().to_string()));
    shell(words.chain(["-o".to_owned(), out.display().to_string()]))
}

/// A line that a shell takes apart into these words.
pub(super) fn shell(words: impl IntoIterator<Item = String>) -> String {
    let is_plain = |word: &str| {
        let plain = |it: char| it.is_ascii_alphanumeric() || "-_./=:,+@%".contains(it);
        !word.is_empty() && word.chars().all(plain)
    };
    let quoted = |word: String| match word {
        word if is_plain(&word) => word,
        word => format!("'{}'", word.replace('\'', r"'\''")),
    };
    words.into_iter().map(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::shell;

    #[test]
    fn words_that_a_shell_would_change_are_quoted() {
        let words = ["rher", "a b", "agent.hidden=[1]", "it's", "", "runs/a-1"];
        let line = shell(words.map(str::to_owned));
        assert_eq!(line, r"rher 'a b' 'agent.hidden=[1]' 'it'\''s' '' runs/a-1");
    }
}
