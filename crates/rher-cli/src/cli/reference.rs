//! The page `docs/commands.md`, which a test compares with the command line.

use super::Cli;
use clap::builder::StyledStr;
use clap::{Arg, Command, CommandFactory as _};
use std::fmt::Write as _;
use std::path::Path;

const INTRODUCTION: &str = "\
# Commands

Every command of `rher`, with all arguments and options; `rher help COMMAND` prints the same.
This page is written from the command line itself:
`RHER_RENEW_DOCS=1 cargo test --release -p rher-cli --lib page_of_commands` renews it.
";

#[test]
fn the_page_of_commands_is_what_the_command_line_says() {
    let page = page();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/commands.md");
    if std::env::var_os("RHER_RENEW_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    assert!(
        std::fs::read_to_string(path).unwrap() == page,
        "renew it: RHER_RENEW_DOCS=1 cargo test --release -p rher-cli --lib page_of_commands"
    );
}

fn page() -> String {
    let mut program = Cli::command();
    program.build();
    let mut text = INTRODUCTION.to_owned();
    for command in shown(&program) {
        describe(command, &mut text);
        for part in shown(command) {
            describe(part, &mut text);
        }
    }
    let status = program.get_after_long_help().unwrap().to_string();
    let status = status.split_once("\n\n").unwrap().1.trim();
    write!(text, "\n## Exit status\n\n```text\n{status}\n```\n").unwrap();
    text
}

/// The commands of a program, or the parts of a command.
fn shown(command: &Command) -> impl Iterator<Item = &Command> {
    command.get_subcommands().filter(|part| part.get_name() != "help" && !part.is_hide_set())
}

fn describe(command: &Command, text: &mut String) {
    let name = command.get_bin_name().unwrap();
    let about = command.get_long_about().or(command.get_about());
    write!(text, "\n## `{name}`\n\n{}\n", sentences(about)).unwrap();
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ");
    write!(text, "\n```text\n{usage}\n```\n").unwrap();
    let mut arguments: Vec<&Arg> = command.get_arguments().filter(|it| is_shown(it)).collect();
    // Those without a name come first.
    arguments.sort_by_key(|argument| !argument.is_positional());
    if !arguments.is_empty() {
        text.push('\n');
    }
    for argument in arguments {
        describe_argument(argument, text);
    }
    let more = command.get_after_long_help().or(command.get_after_help());
    for paragraph in more.map(StyledStr::to_string).unwrap_or_default().trim().split("\n\n") {
        // What is in columns stays as it is.
        if paragraph.contains("\n ") {
            write!(text, "\n```text\n{paragraph}\n```\n").unwrap();
        } else if !paragraph.is_empty() {
            write!(text, "\n{paragraph}\n").unwrap();
        }
    }
}

fn is_shown(argument: &Arg) -> bool {
    !argument.is_hide_set() && !["help", "version"].contains(&argument.get_id().as_str())
}

fn describe_argument(argument: &Arg, text: &mut String) {
    let short = argument.get_short().map(|short| format!("`-{short}`, ")).unwrap_or_default();
    let help = sentences(argument.get_long_help().or(argument.get_help()));
    // What follows the first paragraph stays in the same item of the list.
    write!(text, "- {short}`{argument}`: {}", help.replace("\n\n", "\n\n  ")).unwrap();
    if !argument.get_action().takes_values() {
        text.push('\n');
        return;
    }
    for default in argument.get_default_values() {
        write!(text, " Default: `{}`.", default.to_string_lossy()).unwrap();
    }
    let values = argument.get_possible_values();
    let values: Vec<_> = values.iter().filter(|value| !value.is_hide_set()).collect();
    if values.iter().any(|value| value.get_help().is_some()) {
        text.push('\n');
        for value in values {
            writeln!(text, "  - `{}`: {}", value.get_name(), sentences(value.get_help())).unwrap();
        }
    } else if values.is_empty() {
        text.push('\n');
    } else {
        let names: Vec<String> = values.iter().map(|it| format!("`{}`", it.get_name())).collect();
        writeln!(text, " Values: {}.", names.join(", ")).unwrap();
    }
}

/// Paragraphs of a help text, each with a full stop, which clap leaves out.
fn sentences(help: Option<&StyledStr>) -> String {
    let help = help.map(StyledStr::to_string).unwrap_or_default();
    let ended = help.trim().split("\n\n").map(|paragraph| {
        let paragraph = paragraph.trim();
        match paragraph.strip_suffix(']').and_then(|it| it.rsplit_once(" [default: ")) {
            Some((before, default)) => format!("{before}. Default: {default}."),
            None if paragraph.ends_with('.') => paragraph.to_owned(),
            None => format!("{paragraph}."),
        }
    });
    ended.collect::<Vec<_>>().join("\n\n")
}
