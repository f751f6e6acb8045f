//! `rher config`: the settings of a run, ready to be changed.

use crate::cli::ConfigArgs;
use crate::printer::Printer;
use rher_runs::settings;

pub(crate) fn config(args: &ConfigArgs, printer: Printer) -> anyhow::Result<()> {
    let settings = settings::resolve(args.task, &(&args.settings).into())?;
    printer.data(&settings::to_toml(&settings)?)?;
    Ok(())
}
