//! `rher config`: the settings of a run, ready to be changed.

use crate::cli::ConfigArgs;
use crate::printer::Printer;
use rher_runs::settings::{self, Comments};

pub(crate) fn config(args: &ConfigArgs, printer: Printer) -> anyhow::Result<()> {
    let settings = settings::resolve(args.task, &(&args.settings).into())?;
    let comments = if args.explain { Comments::Full } else { Comments::Short };
    printer.data(&settings::to_toml_with(&settings, comments)?)?;
    Ok(())
}
