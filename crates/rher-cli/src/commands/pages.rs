//! `rher completions` and `rher man`: what a shell and `man` know of the program.

use crate::cli::{Cli, CompletionsArgs, ManArgs};
use crate::printer::{Printer, program_name};
use clap::CommandFactory as _;
use rher_core::files::FileError;
use std::fs;

/// Prints the completions of a shell.
pub(crate) fn completions(args: &CompletionsArgs, printer: Printer) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), program_name(), &mut script);
    printer.data(&String::from_utf8(script)?)?;
    Ok(())
}

/// Writes the manual page of the program, and one for each command.
pub(crate) fn man(args: &ManArgs, printer: Printer) -> anyhow::Result<()> {
    let ManArgs { folder } = args;
    fs::create_dir_all(folder).map_err(FileError::write(folder))?;
    let program = Cli::command().name(program_name()).version(env!("CARGO_PKG_VERSION"));
    clap_mangen::generate_to(program, folder).map_err(FileError::write(folder))?;
    printer.note(format_args!("manual pages in `{}`", folder.display()));
    Ok(())
}
