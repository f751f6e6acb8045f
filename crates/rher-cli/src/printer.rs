//! The one place that writes to the terminal: data to stdout, all else to stderr.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, Write as _};
use std::sync::OnceLock;

/// What this program is called, if not `rher`.
static OTHER_NAME: OnceLock<String> = OnceLock::new();

/// Lets every command that a text recommends begin with the name of this program.
pub(crate) fn call_the_program(name: &str) {
    if name != "rher" {
        OTHER_NAME.get_or_init(|| name.to_owned());
    }
}

/// What this program is called.
pub(crate) fn program_name() -> &'static str {
    OTHER_NAME.get().map_or("rher", String::as_str)
}

/// How much is printed on stderr.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verbosity {
    /// Progress and results.
    Normal,
    /// Errors alone.
    Quiet,
}

/// Decides what reaches the terminal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Printer {
    verbosity: Verbosity,
}

impl Printer {
    pub(crate) fn new(verbosity: Verbosity) -> Self {
        Self { verbosity }
    }

    pub(crate) fn verbosity(self) -> Verbosity {
        self.verbosity
    }

    /// Writes what was asked for; a reader that has gone away has read enough.
    #[expect(clippy::unused_self, reason = "whoever prints goes through a printer")]
    pub(crate) fn data(self, text: &str) -> Result<(), StdoutError> {
        let mut stdout = io::stdout().lock();
        let written = stdout
            .write_all(uncontrolled(text).as_bytes())
            .and_then(|()| if text.ends_with('\n') { Ok(()) } else { stdout.write_all(b"\n") })
            .and_then(|()| stdout.flush());
        match written {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(StdoutError(error)),
            _ => Ok(()),
        }
    }

    /// Tells how things are going.
    pub(crate) fn note(self, text: impl Display) {
        match self.verbosity {
            Verbosity::Normal => tell(text),
            Verbosity::Quiet => {}
        }
    }

    /// Prints what the user should know although the command continues.
    #[expect(clippy::unused_self, reason = "whoever prints goes through a printer")]
    pub(crate) fn warn(self, text: impl Display) {
        tell(format_args!("warning: {text}"));
    }

    /// Tells what went wrong, and the way out.
    #[expect(clippy::unused_self, reason = "whoever prints goes through a printer")]
    pub(crate) fn error(self, error: &anyhow::Error, hint: Option<&str>) {
        tell(format_args!("error: {error:#}"));
        if let Some(hint) = hint {
            tell(format_args!("\nhint: {hint}"));
        }
    }
}

/// Standard output does not take what is written to it.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output")]
pub(crate) struct StdoutError(#[source] pub(crate) io::Error);

/// Prints to stderr; if that is closed, there is nowhere to say so.
fn tell(text: impl Display) {
    let mut text = text.to_string();
    if let Some(name) = OTHER_NAME.get() {
        text = text.replace("`rher ", &format!("`{name} "));
    }
    let _ = writeln!(io::stderr().lock(), "{}", printable(&text));
}

/// Data without characters that command a terminal; lines of data have any length.
fn uncontrolled(text: &str) -> Cow<'_, str> {
    if text.chars().any(commands) {
        text.chars().fold(String::with_capacity(text.len()), add).into()
    } else {
        text.into()
    }
}

fn commands(character: char) -> bool {
    character.is_control() && character != '\t' && character != '\n'
}

fn add(mut text: String, character: char) -> String {
    if commands(character) {
        text.extend(character.escape_default());
    } else {
        text.push(character);
    }
    text
}

/// Longest line in characters; names in files may have any length.
const LONGEST_LINE: usize = 2000;

/// Text for a terminal: without characters that command it, and with long lines cut. Names in
/// files may hold such characters and have any length.
fn printable(text: &str) -> String {
    let cut = |line: &str| match line.char_indices().nth(LONGEST_LINE) {
        Some((at, _)) => format!("{}… ({} bytes more)", &line[..at], line.len() - at),
        None => line.to_owned(),
    };
    uncontrolled(text).split('\n').map(cut).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_command_the_terminal_is_escaped_and_long_lines_are_cut() {
        assert_eq!(printable("a\u{1b}[2Jb\r\tc\nd"), "a\\u{1b}[2Jb\\r\tc\nd");
        let long = printable(&format!("{}\nend", "é".repeat(LONGEST_LINE + 1)));
        assert!(long.ends_with("é… (2 bytes more)\nend"), "{long}");
    }
}
