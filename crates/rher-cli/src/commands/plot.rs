//! `rher plot`: learning curves.

use super::stats::note_repeated;
use crate::cli::PlotArgs;
use crate::plot::Figure;
use crate::printer::Printer;
use anyhow::Context as _;
use rher_core::files;
use rher_runs::{Groups, read_groups};

pub(crate) fn plot(args: &PlotArgs, printer: Printer) -> anyhow::Result<()> {
    let Groups { groups, repeated } = read_groups(&args.runs)?;
    note_repeated(&repeated, printer);
    let drawing = Figure { clock: args.x, measure: args.measure }.draw(&groups);
    let file = if args.out.extension().is_some_and(|extension| extension == "png") {
        let image =
            drawing.image().context("too many tasks for one picture: expected fewer runs")?;
        image.png()?
    } else {
        drawing.svg().into_bytes()
    };
    files::replace(&args.out, &file)?;
    printer.note(format_args!("curves  {}", args.out.display()));
    Ok(())
}
