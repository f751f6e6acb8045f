//! `rher stats`: what runs reached, how soon, and how sure that is.

mod numbers;
mod profiles;
mod tables;

pub(super) use numbers::Stats;
pub(super) use profiles::{PROFILES, profiles};
pub(super) use tables::{NOTE, sections};

use crate::chosen::Chosen;
use crate::cli::StatsArgs;
use crate::plot::Sheet;
use crate::printer::Printer;
use crate::tables::text;
use comfy_table::presets::ASCII_MARKDOWN;

pub(crate) fn stats(args: &StatsArgs, printer: Printer) -> anyhow::Result<()> {
    let Chosen { groups, unfinished } = Chosen::read(&args.runs, printer)?;
    for (group, runs) in &groups {
        if runs.iter().any(|run| run.settings != runs[0].settings) {
            printer.note(format_args!(
                "note: the runs of {group} differ in more than the seed; compare their `config.toml`"
            ));
        }
    }
    let stats = Stats::of(&groups, unfinished);
    if let Some(out) = &args.out {
        let drawing =
            Sheet { title: None, rows: profiles(&groups, &stats), caption: PROFILES.to_owned() }
                .draw();
        drawing.write(out, "Performance profiles and probability of improvement")?;
        printer.note(format_args!("profiles  {}", out.display()));
    }
    let output = if args.json {
        serde_json::to_string_pretty(&stats)?
    } else if args.markdown {
        tables::describe(&stats, |mut table| {
            table.load_style(ASCII_MARKDOWN);
            table.to_string() + "\n"
        })
    } else {
        tables::describe(&stats, |table| text(&table))
    };
    printer.data(&output)?;
    Ok(())
}
