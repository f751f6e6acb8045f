//! `rher plot`: learning curves.

use crate::chosen::Chosen;
use crate::cli::PlotArgs;
use crate::plot::{Figure, View};
use crate::printer::Printer;
use rher_runs::is_in_use;

pub(crate) fn plot(args: &PlotArgs, printer: Printer) -> anyhow::Result<()> {
    let Chosen { groups, unfinished } = Chosen::read(&args.runs, printer)?;
    if !unfinished.is_empty() {
        let cells = unfinished.len();
        printer.note(format_args!(
            "{cells} cells are not done; `rher sweep --status PLAN` lists them"
        ));
    }
    let figure = Figure {
        view: View { clock: args.x, measure: args.measure },
        title: args.title.clone(),
        columns: args.columns,
        subtasks: !args.no_subtasks,
        running: groups
            .iter()
            .flat_map(|(_, runs)| runs)
            .filter(|run| is_in_use(&run.folder))
            .count(),
    };
    let label = args.title.as_deref().unwrap_or("Learning curves");
    figure.draw(&groups).write(&args.out, label)?;
    printer.note(format_args!("curves  {}", args.out.display()));
    Ok(())
}
