//! The program, with the tasks that it knows.

use crate::exit_code::Status;
use crate::host::Again;
use crate::printer::Printer;
use crate::{cli, commands, errors, printer, shipped, tips};
use clap::builder::StyledStr;
use clap::{Command, CommandFactory as _, FromArgMatches as _};
use rher_envs::{ObjectCount, Scenario, Simulated, Task, TaskNameError, TaskObjects};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The program `rher`, or one that also knows tasks of its own.
///
/// ```no_run
/// # use rher_envs::tasks::Push as Corner;
/// fn main() -> std::process::ExitCode {
///     rher_cli::Program::new().task::<Corner, 1>().main()
/// }
/// ```
///
/// Such a program has every command of `rher`: it trains, resumes, evaluates, sweeps and reports
/// its tasks by their names.
#[derive(Clone, Debug)]
pub struct Program {
    again: Again,
    /// A task that could not be added, the first one.
    refused: Option<TaskNameError>,
}

impl Program {
    /// The program that is running.
    #[must_use]
    pub fn new() -> Self {
        Self { again: Again::this_file(), refused: None }
    }

    /// An interpreter, and the arguments that make it this program.
    #[must_use]
    pub const fn interpreted(interpreter: PathBuf, arguments: Vec<OsString>) -> Self {
        Self { again: Again::new(interpreter, arguments), refused: None }
    }

    /// Adds the task that `S` describes; [`run`](Self::run) reports a name that is taken.
    #[must_use]
    pub fn task<S: Scenario<N>, const N: usize>(self) -> Self
    where
        ObjectCount: TaskObjects<N>,
    {
        self.with(Task::add_scenario::<S, N>())
    }

    /// Adds a task whose environments `build` makes, on Rapier or not; it is called as their
    /// specification says, and [`run`](Self::run) reports a name that is taken.
    #[must_use]
    pub fn env<E: Simulated<N>, const N: usize>(
        self,
        build: impl Fn() -> E + Send + Sync + 'static,
    ) -> Self
    where
        ObjectCount: TaskObjects<N>,
    {
        self.with(Task::add_env(build))
    }

    fn with(mut self, added: Result<Task, TaskNameError>) -> Self {
        self.refused = self.refused.or(added.err());
        self
    }

    /// Does what the arguments of this process say.
    pub fn main(self) -> ExitCode {
        self.run(std::env::args_os()).into()
    }

    /// Does what `arguments` say, of which the first is the name of the program, and returns the
    /// exit status.
    pub fn run(&self, arguments: impl IntoIterator<Item = OsString>) -> u8 {
        let arguments: Vec<OsString> = arguments.into_iter().collect();
        let name = arguments.first().and_then(|path| Path::new(path).file_name()?.to_str());
        printer::call_the_program(name.unwrap_or("rher"));
        let matches = own_words(cli::Cli::command()).try_get_matches_from(arguments);
        let cli = match matches.and_then(|matches| cli::Cli::from_arg_matches(&matches)) {
            Ok(cli) => cli,
            Err(mut error) => {
                tips::add(&mut error);
                // If the terminal does not take it, there is nowhere to say so.
                let _ = error.print();
                return u8::try_from(error.exit_code()).unwrap_or(Status::Usage as u8);
            }
        };
        let printer = Printer::new(cli.verbosity());
        let done = match &self.refused {
            Some(refused) => Err(refused.clone().into()),
            None => commands::run(cli.command, &self.again, printer),
        };
        shipped::remove();
        let status = done.unwrap_or_else(|error| {
            let report = errors::report(&error);
            printer.error(&error, report.hint.as_deref());
            report.status
        });
        status as u8
    }
}

/// The command line of a program that may not be called `rher`: its texts recommend what it can do.
fn own_words(command: Command) -> Command {
    match printer::program_name() {
        "rher" => command,
        name => with_name(command, name).name(name),
    }
}

fn with_name(command: Command, name: &'static str) -> Command {
    let own = |text: &StyledStr| text.to_string().replace("rher ", &format!("{name} "));
    let after = command.get_after_help().map(own);
    let after_long = command.get_after_long_help().map(own);
    let mut command = command.mut_subcommands(|command| with_name(command, name));
    if let Some(text) = after {
        command = command.after_help(text);
    }
    if let Some(text) = after_long {
        command = command.after_long_help(text);
    }
    command
}

impl Default for Program {
    fn default() -> Self {
        Self::new()
    }
}
