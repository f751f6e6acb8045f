//! `rher report`: what runs came to, on one page that needs no other file.

mod facts;
mod film;
mod listing;
mod page;
mod settings;

pub(super) use film::film;
pub(super) use settings::train_command;

use super::stats::{NOTE, PROFILES, Stats, profiles, sections};
use crate::chosen::Chosen;
use crate::cli::ReportArgs;
use crate::output;
use crate::plot::{Clock, Looks, Measure, View, by_task, name, quantities};
use crate::printer::Printer;
use page::{Page, Size};
use rher_runs::{Group, Run};

pub(crate) fn report(args: &ReportArgs, printer: Printer) -> anyhow::Result<()> {
    let Chosen { groups, unfinished } = Chosen::read(&args.runs, printer)?;
    let looks = Looks::of(groups.iter().map(|(group, _)| name(group)));
    let stats = Stats::of(&groups, unfinished);
    let mut page = Page::default();
    add_success(&mut page, &groups, &looks);
    add_statistics(&mut page, &groups, &stats);
    add_episodes(&mut page, &groups, printer);
    add_metrics(&mut page, &groups, &looks)?;
    page.section("Runs");
    page.table("The last evaluation of each run", &listing::runs(&groups));
    page.section("Settings");
    for (group, runs) in &groups {
        settings::add(&mut page, group, runs)?;
    }
    page.section("Hardware");
    page.table("Programs and machines", &listing::machines(&groups));
    let page = page.finish(&facts::title(&groups), &facts::facts(args, &groups));
    output::write(&args.out, page.as_bytes())?;
    printer.note(format_args!("report  {}", args.out.display()));
    Ok(())
}

const fn against(clock: Clock) -> View {
    View { clock, measure: Measure::Mean }
}

fn add_success(page: &mut Page, groups: &[(Group, Vec<Run>)], looks: &Looks) {
    page.section("Success");
    page.paragraph(&format!(
        "{} Dashed: what the authors of the method published for the task, if they did. Point at a \
         chart to see its numbers.",
        Measure::Mean.caption()
    ));
    for groups in by_task(groups) {
        page.part(&groups[0].0.task);
        let (steps, time) = (against(Clock::Steps), against(Clock::Time));
        let mut panels = vec![steps.success(groups, looks), time.success(groups, looks)];
        panels.extend(steps.subtasks(groups, looks));
        page.charts(&panels, Size::Large);
    }
}

fn add_statistics(page: &mut Page, groups: &[(Group, Vec<Run>)], stats: &Stats) {
    page.section("Statistics");
    for (title, table) in sections(stats) {
        page.table(title, &table);
    }
    page.paragraph(NOTE);
    page.part("Performance profiles");
    page.paragraph(PROFILES);
    page.charts(&profiles(groups, stats).concat(), Size::Small);
}

fn add_episodes(page: &mut Page, groups: &[(Group, Vec<Run>)], printer: Printer) {
    page.section("Episodes");
    let mut pictures = Vec::new();
    for (group, runs) in groups {
        match film::episode(group, runs, printer) {
            Some(picture) => pictures.push(picture),
            None => page
                .paragraph(&format!("No run of {group} has a policy that this program can show.")),
        }
    }
    page.pictures(&pictures);
}

fn add_metrics(page: &mut Page, groups: &[(Group, Vec<Run>)], looks: &Looks) -> anyhow::Result<()> {
    page.section("Metrics");
    page.paragraph(
        "Everything else in metrics.jsonl, against environment steps. Lines and bands are as above.",
    );
    let view = against(Clock::Steps);
    for groups in by_task(groups) {
        page.part(&groups[0].0.task);
        let end = view.end(groups);
        let quantities = quantities(groups)?;
        let panels = quantities.iter().map(|it| view.panels(it, groups, looks, end));
        page.charts(&panels.collect::<Vec<_>>().concat(), Size::Small);
    }
    Ok(())
}
