//! `rher report`: what runs came to, on one page that needs no other file.

use super::stats::{NOTE, Stats, sections};
use crate::chosen::Chosen;
use crate::cli::ReportArgs;
use crate::film::{Animation, Film};
use crate::numbers::{duration, percent, thousands};
use crate::plot::{Clock, Figure, Measure, View, escaped};
use crate::printer::Printer;
use crate::trained::Trained;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use comfy_table::Table;
use rher_core::files::{self, FileError};
use rher_core::train::checkpoint::POLICY_FILE;
use rher_runs::{CONFIG_FILE, Group, Machine, Run};
use std::fmt::{self, Write as _};
use std::path::Path;

const STYLE: &str = "\
body { font: 15px/1.5 sans-serif; color: #222; max-width: 1100px; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.6em } h2 { font-size: 1.2em; margin-top: 2em }
table { border-collapse: collapse; margin: .5em 0 1.5em } caption { text-align: left; color: #555 }
th, td { text-align: left; padding: .2em .9em .2em 0; border-bottom: 1px solid #ddd }
figure { display: inline-block; margin: 0 1em 1em 0 } figcaption { color: #555 }
svg, img { max-width: 100%; height: auto } pre { background: #f5f5f5; padding: .8em; overflow: auto }";

pub(crate) fn report(args: &ReportArgs, printer: Printer) -> anyhow::Result<()> {
    let Chosen { groups, unfinished } = Chosen::read(&args.runs, printer)?;
    let mut page = Page::default();
    let titles: Vec<String> = groups.iter().map(|(group, _)| group.to_string()).collect();
    page.element("h1", &format!("Runs of {}", titles.join(", ")));

    page.element("h2", "Success");
    for clock in [Clock::Steps, Clock::Time] {
        let view = View { clock, measure: Measure::Mean };
        let figure = Figure { view, title: None, columns: None, subtasks: true, running: 0 };
        page.0 += &figure.draw(&groups).svg("Success");
    }
    page.element(
        "p",
        "Lines are means over runs; bands are 95 % bootstrap intervals. Dashed: what the authors \
         of the method published for the task, if they did.",
    );
    for (title, table) in sections(&Stats::of(&groups, unfinished)) {
        page.table(title, &table);
    }
    page.element("p", NOTE);

    page.element("h2", "An episode");
    for (group, runs) in &groups {
        match runs.iter().map(|run| &run.folder).find(|folder| has_policy(folder)) {
            Some(folder) => {
                let caption =
                    format!("{group}: the first evaluation episode of {}", folder.display());
                page.picture(&caption, "image/gif", &film(folder, printer)?);
            }
            None => page.element("p", &format!("No run of {group} has a policy to show.")),
        }
    }

    page.element("h2", "Runs");
    page.table("The last evaluation of each run", &listing(&groups));

    page.element("h2", "Settings");
    for (group, runs) in &groups {
        for Run { folder, .. } in runs.iter().take(1) {
            let path = folder.join(CONFIG_FILE);
            let settings = std::fs::read_to_string(&path);
            let settings = settings.map_err(FileError::read(&path))?;
            page.details(&format!("{group}, as in {}", folder.display()), &settings);
        }
    }

    page.element("h2", "Hardware");
    page.table("Programs and machines", &machines(&groups));
    files::replace(&args.out, page.finish(&titles.join(", ")).as_bytes())?;
    printer.note(format_args!("report  {}", args.out.display()));
    Ok(())
}

fn has_policy(folder: &Path) -> bool {
    folder.join(POLICY_FILE).exists()
}

/// The first evaluation episode of a run's policy, as a GIF file.
fn film(folder: &Path, printer: Printer) -> anyhow::Result<Vec<u8>> {
    let trained = Trained::load(folder, printer)?;
    let (task, policy, test_policy) = (trained.task, &trained.policy, trained.test_policy());
    let footage = task.visit_with(&trained.options, Film { task, policy, test_policy })??;
    let animation = Animation::of(&footage.images)?;
    Ok(animation.map(Animation::finish).transpose()?.unwrap_or_default())
}

fn listing(groups: &[(Group, Vec<Run>)]) -> Table {
    let mut listing = Table::new();
    listing.set_header(["folder", "task", "seed", "evaluations", "steps", "wall clock", "success"]);
    for run in groups.iter().flat_map(|(_, runs)| runs) {
        let last = run.last();
        listing.add_row([
            run.folder.display().to_string(),
            run.group.to_string(),
            run.seed.to_string(),
            run.evaluations.len().to_string(),
            thousands(last.env_steps),
            duration(last.wall_s),
            percent(last.success_final),
        ]);
    }
    listing
}

/// What made each of the runs, as far as that was kept, and what made this page.
fn machines(groups: &[(Group, Vec<Run>)]) -> Table {
    let mut machines = Table::new();
    machines.set_header(["what", "program", "system", "processor", "cores"]);
    let folders = groups.iter().flat_map(|(_, runs)| runs).map(|run| &run.folder);
    let runs = folders.map(|path| (path.display().to_string(), Machine::of_run(path)));
    for (what, machine) in runs.chain([("this page".to_owned(), Ok(Some(Machine::here())))]) {
        let row = match machine {
            Ok(Some(Machine { program, system, processor, cores })) => {
                [program, system, processor, cores.to_string()]
            }
            Ok(None) => ["unknown", "", "", ""].map(str::to_owned),
            Err(_) => ["its `machine.toml` is damaged", "", "", ""].map(str::to_owned),
        };
        machines.add_row([what].into_iter().chain(row));
    }
    machines
}

/// The body of a page.
#[derive(Default)]
struct Page(String);

impl Page {
    fn add(&mut self, markup: fmt::Arguments<'_>) {
        // A string takes whatever is written.
        let _ = self.0.write_fmt(markup);
    }

    fn element(&mut self, name: &str, text: &str) {
        self.add(format_args!("<{name}>{}</{name}>\n", escaped(text)));
    }

    fn table(&mut self, title: &str, table: &Table) {
        let row = |row: &comfy_table::Row, name: &str| {
            let cell = |cell: &comfy_table::Cell| {
                format!("<{name}>{}</{name}>", escaped(cell.content().trim()))
            };
            format!("<tr>{}</tr>\n", row.cell_iter().map(cell).collect::<String>())
        };
        let head = table.header().map_or_else(String::new, |header| row(header, "th"));
        let body: String = table.row_iter().map(|line| row(line, "td")).collect();
        let caption = escaped(title);
        self.add(format_args!("<table><caption>{caption}</caption>\n{head}{body}</table>\n"));
    }

    fn picture(&mut self, caption: &str, kind: &str, file: &[u8]) {
        let (data, caption) = (STANDARD.encode(file), escaped(caption));
        self.add(format_args!(
            "<figure><img alt=\"{caption}\" src=\"data:{kind};base64,{data}\">\
             <figcaption>{caption}</figcaption></figure>\n"
        ));
    }

    fn details(&mut self, title: &str, text: &str) {
        let (title, text) = (escaped(title), escaped(text));
        self.add(format_args!("<details><summary>{title}</summary><pre>{text}</pre></details>\n"));
    }

    /// The whole file; its icon is empty, so that no browser asks for one.
    fn finish(self, title: &str) -> String {
        let (Self(body), title) = (self, escaped(title));
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <title>rher: {title}</title>\n<link rel=\"icon\" href=\"data:,\">\n\
             <style>\n{STYLE}\n</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
        )
    }
}
