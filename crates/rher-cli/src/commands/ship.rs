//! `rher reproduce shipped`: the policies that ship with the program.

use super::eval::judge;
use crate::cli::{ReproduceArgs, SettingsArgs};
use crate::exit_code::Status;
use crate::host::{Again, threads};
use crate::jobs::{Job, Work};
use crate::numbers::thousands;
use crate::printer::Printer;
use crate::trained::{Trained, sha256};
use rher_core::config::Preset;
use rher_core::files::{self, FileError};
use rher_core::train::checkpoint::POLICY_FILE;
use rher_envs::Task;
use rher_policies::Card;
use rher_runs::{CONFIG_FILE, METRICS_FILE, Run, settings};
use std::fs;
use std::path::Path;

/// Episodes that a policy is judged by.
const EPISODES: usize = 1000;

/// Their seed; training is judged by those of seed 0.
const ENV_SEED: u64 = 1;

const PROVENANCE: &str = "Trained from random weights in the simulator of this program, on its own \
                          sparse reward, without demonstrations or other data. MIT or Apache-2.0, \
                          like the program.";

/// A run whose policy ships.
struct Recipe {
    task: Task,
    /// Where it ends, if not where `rher train TASK` does: after so many steps, whatever its
    /// success.
    env_steps: Option<u64>,
    /// The success that ends it, if not that of `rher train TASK`.
    until: Option<f32>,
}

/// Tasks that are solved before their policies are as good as they become train longer.
const RECIPES: &[Recipe] = &[
    Recipe::new(Task::REACH),
    Recipe::new(Task::PUSH),
    Recipe::new(Task::PICK),
    Recipe { task: Task::SLIDE, env_steps: None, until: Some(0.9) },
    Recipe::new(Task::INSERT),
    Recipe::of_steps(Task::OBSTACLE_PUSH, 100_000),
    Recipe::new(Task::DRAWER),
    Recipe::new(Task::CUE_PUSH),
    Recipe::of_steps(Task::DPUSH, 90_000),
    Recipe::of_steps(Task::STACK, 90_000),
    Recipe::new(Task::DRAWER_BOX),
    Recipe::of_steps(Task::TPUSH, 500_000),
    Recipe::of_steps(Task::TSTACK, 500_000),
];

impl Recipe {
    const fn new(task: Task) -> Self {
        Self { task, env_steps: None, until: None }
    }

    const fn of_steps(task: Task, env_steps: u64) -> Self {
        Self { task, env_steps: Some(env_steps), until: Some(0.0) }
    }

    fn command(&self) -> String {
        let task = self.task.name();
        let until = self.until.map(|until| format!(" --until {until}")).unwrap_or_default();
        let steps = self.env_steps.map(|steps| format!(" --env-steps {steps}")).unwrap_or_default();
        format!("rher train {task} --seed 1{until}{steps}")
    }

    fn job(&self, args: &ReproduceArgs, out: &Path) -> anyhow::Result<Job> {
        let asked = SettingsArgs {
            preset: Some(args.preset.unwrap_or(Preset::Fast)),
            config: None,
            set: Vec::new(),
            method: None,
            seed: Some(1),
            env_steps: args.env_steps.or(self.env_steps),
            until: self.until,
            engine: None,
            precision: None,
            envs: None,
        };
        let settings = settings::resolve_here(self.task, &(&asked).into())?;
        Ok(Job::new(out, self.task.name().to_owned(), self.task, settings))
    }

    /// Judges the policy of a finished run, and copies what ships of it.
    fn ship(&self, run: &Path, to: &Path, printer: Printer) -> anyhow::Result<()> {
        let trained = Trained::load(run, printer)?;
        let report = judge(&trained, &trained.options, EPISODES, ENV_SEED, threads(None))?;
        fs::create_dir_all(to).map_err(FileError::write(to))?;
        let mut policy_sha256 = String::new();
        for name in [CONFIG_FILE, METRICS_FILE, POLICY_FILE] {
            let (from, to) = (run.join(name), to.join(name));
            let bytes = fs::read(&from).map_err(FileError::read(&from))?;
            policy_sha256 = sha256(&bytes);
            files::replace(&to, &bytes)?;
        }
        let card = Card {
            task: self.task.name().to_owned(),
            about: self.task.about().to_owned(),
            command: self.command(),
            env_steps: Run::read(run)?.last().env_steps,
            episodes: EPISODES,
            env_seed: ENV_SEED,
            success: report.success_final,
            ci95: report.ci95,
            subtasks: report.success,
            final_distance: report.final_distance,
            rher: env!("CARGO_PKG_VERSION").to_owned(),
            policy_sha256,
            provenance: PROVENANCE.to_owned(),
        };
        let text = serde_json::to_string_pretty(&card)? + "\n";
        files::replace(&to.join("card.json"), text.as_bytes())?;
        printer.note(format_args!(
            "{:<14} {:5.1} % of {} episodes",
            card.task,
            100.0 * card.success,
            thousands(EPISODES as u64)
        ));
        Ok(())
    }
}

/// Trains every policy that ships, judges it, and puts into the folder `shipped` below `out` what
/// the crate `rher-policies` has in its folder `runs`.
pub(super) fn ship(
    args: &ReproduceArgs,
    out: &Path,
    again: &Again,
    printer: Printer,
) -> anyhow::Result<Status> {
    let jobs: Vec<Job> =
        RECIPES.iter().map(|recipe| recipe.job(args, out)).collect::<Result<_, _>>()?;
    let work = Work { jobs: &jobs, plan: None, at_a_time: threads(args.runs.jobs) };
    let status = work.run(args.runs.json, again, printer)?;
    if status != Status::Success {
        return Ok(status);
    }
    for (recipe, job) in RECIPES.iter().zip(&jobs) {
        recipe.ship(&job.folder, &out.join("shipped").join(recipe.task.name()), printer)?;
    }
    Ok(status)
}
