//! Statistics as tables.

use super::numbers::{Comparison, Estimate, GroupStats, RATES, Reached, Stats};
use crate::chosen::{UNFINISHED, unfinished};
use crate::numbers::{duration, percent, thousands};
use crate::tables::table;
use comfy_table::Table;
use rher_runs::Group;

/// What the tables do not say.
pub(crate) const NOTE: &str = "In brackets: 95 % bootstrap intervals over runs, where there are \
                               several. Times are those of the median run.";

impl Estimate {
    fn show(self, number: impl Fn(f64) -> String) -> String {
        let show = |value: Option<f64>| value.map_or("never".to_owned(), &number);
        match self.ci95 {
            Some([low, high]) => format!("{} [{}, {}]", show(self.value), show(low), show(high)),
            None => show(self.value),
        }
    }
}

pub(super) fn describe(stats: &Stats, show: impl Fn(Table) -> String) -> String {
    let sections = sections(stats).into_iter();
    let mut texts: Vec<String> =
        sections.map(|(title, table)| format!("{title}\n\n{}", show(table))).collect();
    texts.push(format!("{NOTE}\n"));
    texts.join("\n")
}

/// Titles and tables.
pub(crate) fn sections(stats: &Stats) -> Vec<(&'static str, Table)> {
    let mut success = table();
    success.set_header(["task", "method", "preset", "runs", "final success", "interquartile mean"]);
    let columns = RATES.map(percent);
    let header = ["task", "method", "preset"].map(str::to_owned).into_iter().chain(columns);
    let mut steps = table();
    steps.set_header(header.clone());
    let mut seconds = table();
    seconds.set_header(header);
    for GroupStats { group, seeds, success_final, success_final_iqm, reached } in &stats.groups {
        let Group { task, method, preset } = group;
        let name = [task, method, preset].map(String::clone);
        success.add_row(name.clone().into_iter().chain([
            seeds.len().to_string(),
            success_final.show(percent),
            success_final_iqm.show(percent),
        ]));
        let row = |show: &dyn Fn(&Reached) -> String| {
            let cell = |reached: &Reached| match (reached.runs, seeds.len()) {
                (0, _) => "never".to_owned(),
                (some, all) if some < all => format!("{} ({some} of {all})", show(reached)),
                _ => show(reached),
            };
            name.clone().into_iter().chain(reached.iter().map(cell).collect::<Vec<_>>())
        };
        let whole = |steps: f64| thousands(steps as u64);
        steps.add_row(row(&|reached| reached.env_steps.show(whole)));
        seconds.add_row(row(&|reached| reached.wall_s.show(duration)));
    }
    let mut sections = vec![
        ("Success at the last evaluation", success),
        ("Environment steps to the first evaluation of", steps),
        ("Wall clock to the first evaluation of", seconds),
    ];
    if !stats.comparisons.is_empty() {
        let mut comparisons = table();
        comparisons.set_header([
            "task",
            "a run of",
            "better than one of",
            "higher final success",
            "95 % in fewer steps",
            "95 % in less time",
        ]);
        for Comparison { task, of, over, success_final, env_steps, wall_s } in &stats.comparisons {
            let [success_final, env_steps, wall_s] =
                [success_final, env_steps, wall_s].map(|estimate| estimate.show(percent));
            comparisons.add_row([task, of, over, &success_final, &env_steps, &wall_s]);
        }
        sections.push(("Probability of improvement", comparisons));
    }
    sections.extend(unfinished(&stats.unfinished).map(|listing| (UNFINISHED, listing)));
    sections
}
