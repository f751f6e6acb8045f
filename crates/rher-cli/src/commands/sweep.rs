//! `rher sweep`: a grid of runs.

use crate::cli::{SettingsArgs, SweepArgs};
use crate::errors::RepeatedKey;
use crate::exit_code::Status;
use crate::host::{Program, threads};
use crate::jobs::{self, Job};
use crate::printer::Printer;
use crate::values::Assignment;
use rher_runs::settings;
use std::path::Path;

pub(crate) fn sweep(
    args: &SweepArgs,
    program: &Program,
    printer: Printer,
) -> anyhow::Result<Status> {
    let out =
        args.out.clone().unwrap_or_else(|| Path::new("runs").join(format!("sweep-{}", args.task)));
    jobs::run(&grid(args)?, threads(args.runs.jobs), &out, args.runs.json, program, printer)
}

/// Every combination of values and seeds.
fn grid(args: &SweepArgs) -> anyhow::Result<Vec<Job>> {
    let keys: Vec<&str> = args.vary.iter().map(|axis| axis.key.as_str()).collect();
    if let Some(index) = (1..keys.len()).find(|&index| keys[..index].contains(&keys[index])) {
        return Err(RepeatedKey { key: keys[index].to_owned() }.into());
    }
    let mut combinations = vec![Vec::new()];
    for axis in &args.vary {
        combinations = combinations
            .iter()
            .flat_map(|before| {
                axis.values.iter().map(|value| {
                    let assignment = Assignment { key: axis.key.clone(), value: value.clone() };
                    [before.as_slice(), &[assignment]].concat()
                })
            })
            .collect();
    }
    let seeds = &args.runs.seeds.0;
    let job = |varied: &[Assignment], seed| -> anyhow::Result<Job> {
        let asked = SettingsArgs {
            preset: args.preset,
            config: args.config.clone(),
            set: varied.to_vec(),
            method: args.method,
            seed: Some(seed),
            env_steps: args.runs.env_steps,
            until: args.until,
            engine: None,
            precision: None,
            envs: None,
        };
        let settings = settings::resolve_here(args.task, &(&asked).into())?;
        Ok(Job { cell: cell(varied), task: args.task, settings })
    };
    let of_seeds =
        |varied: &Vec<_>| seeds.iter().map(|&seed| job(varied, seed)).collect::<Vec<_>>();
    combinations.iter().flat_map(of_seeds).collect()
}

/// Such as `relay.mirror=0.5 agent.hidden=[8,8]`.
fn cell(varied: &[Assignment]) -> String {
    let parts = varied.iter().map(|a| format!("{}={}", a.key, a.value).replace(' ', ""));
    parts.collect::<Vec<_>>().join(" ")
}
