//! `rher plot`: learning curves.

use crate::chosen::Chosen;
use crate::cli::PlotArgs;
use crate::plot::Figure;
use crate::printer::Printer;
use anyhow::Context as _;
use rher_core::files;

pub(crate) fn plot(args: &PlotArgs, printer: Printer) -> anyhow::Result<()> {
    let Chosen { groups, unfinished } = Chosen::read(&args.runs, printer)?;
    if !unfinished.is_empty() {
        let cells = unfinished.len();
        printer.note(format_args!(
            "{cells} cells are not done; `rher sweep --status PLAN` lists them"
        ));
    }
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
