//! `rher reproduce`: the paper's experiments, each by one command.

use super::ship::ship;
use crate::cli::{ReproduceArgs, SettingsArgs};
use crate::exit_code::Status;
use crate::host::Again;
use crate::host::threads;
use crate::jobs::{Job, Work};
use crate::printer::Printer;
use crate::values::{Assignment, ExperimentName, Seeds};
use rher_core::config::{Method, Preset};
use rher_envs::Task;
use rher_runs::settings;
use std::path::Path;

pub(crate) fn reproduce(
    args: &ReproduceArgs,
    again: &Again,
    printer: Printer,
) -> anyhow::Result<Status> {
    let name = args.experiment.name();
    let folder = || Path::new("runs").join(format!("reproduce-{name}"));
    let out = args.out.clone().unwrap_or_else(folder);
    let Some(experiment) = Experiment::of(args.experiment) else {
        return ship(args, &out, again, printer);
    };
    printer.note(format_args!("the paper reports: {}", experiment.claim));
    let seeds = args.seeds.clone().unwrap_or(Seeds((1..=3).collect())).0;
    let of_seeds =
        |case: &Case| seeds.iter().map(|&seed| case.job(args, &out, seed)).collect::<Vec<_>>();
    let jobs = experiment.cases.iter().flat_map(of_seeds).collect::<anyhow::Result<Vec<_>>>()?;
    let work = Work { jobs: &jobs, plan: None, at_a_time: threads(args.runs.jobs) };
    work.run(args.runs.json, again, printer)
}

/// One experiment of the paper.
struct Experiment {
    /// What the paper says came out.
    claim: &'static str,
    cases: Vec<Case>,
}

/// What is trained once for every seed.
struct Case {
    label: String,
    task: Task,
    method: Method,
    set: Vec<Assignment>,
    envs: Option<u64>,
    env_steps: u64,
    until: f32,
}

impl Case {
    /// A run that ends when it is solved, or after so many steps.
    fn new(label: String, task: Task, env_steps: u64) -> Self {
        let set = Vec::new();
        Self { label, task, method: Method::Rher, set, envs: None, env_steps, until: 0.95 }
    }

    fn set(mut self, key: &str, value: impl Into<toml::Value>) -> Self {
        self.set.push(Assignment { key: key.to_owned(), value: value.into() });
        self
    }

    fn job(&self, args: &ReproduceArgs, out: &Path, seed: u64) -> anyhow::Result<Job> {
        let asked = SettingsArgs {
            preset: Some(args.preset.unwrap_or(Preset::Paper)),
            config: None,
            set: self.set.clone(),
            method: Some(self.method),
            seed: Some(seed),
            env_steps: Some(args.env_steps.unwrap_or(self.env_steps)),
            until: Some(self.until),
            engine: None,
            precision: None,
            envs: self.envs,
        };
        let settings = settings::resolve_here(self.task, &(&asked).into())?;
        Ok(Job::new(out, self.label.clone(), self.task, settings))
    }
}

impl Experiment {
    /// `None` for what the paper has none of.
    fn of(name: ExperimentName) -> Option<Self> {
        Some(match name {
            ExperimentName::Shipped => return None,
            ExperimentName::Policies => Self {
                claim: "Table I: with the guide and the learner in turn in training and the \
                        learner alone in evaluation (mix/final), push is learned soonest and best; \
                        with the guide alone in training, the learner alone fails",
                cases: ["mix", "guide"]
                    .into_iter()
                    .flat_map(|train| ["final", "guide", "mix"].map(|test| (train, test)))
                    .map(|(train, test)| {
                        Case::new(format!("train={train} test={test}"), Task::PUSH, 150_000)
                            .set("exploration.train_policy", train)
                            .set("exploration.test_policy", test)
                    })
                    .collect(),
            },
            ExperimentName::ReachDistance => Self {
                claim: "d = 0.03 and 0.05 are best, 0.12 is worse, 0 hinders the second sub-task",
                cases: [0.0, 0.03, 0.05, 0.12]
                    .map(|d| {
                        Case::new(format!("d={d}"), Task::PUSH, 150_000)
                            .set("relay.reach_distance", d)
                    })
                    .into(),
            },
            ExperimentName::GuideRate => Self {
                claim: "α = 0.2 to 0.6 all speed push up; 0 is no faster than plain hindsight; \
                        0.8, where the learner never acts before the object is reached, fails",
                cases: [0.0, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8]
                    .map(|alpha| {
                        Case::new(format!("alpha={alpha}"), Task::PUSH, 150_000)
                            .set("exploration.guide", alpha)
                    })
                    .into(),
            },
            ExperimentName::Envs => Self {
                claim: "one environment needs fewer steps than 19 side by side",
                cases: [1, 19]
                    .map(|envs| Case {
                        envs: Some(envs),
                        ..Case::new(format!("envs={envs}"), Task::PUSH, 500_000)
                    })
                    .into(),
            },
            ExperimentName::Her => Self {
                claim: "plain hindsight needs 1,345,000 steps on push and 1,885,000 on pick where \
                        the relay needs 65,000 and 243,000; its seeds differ much on the other \
                        tasks with one object, and it fails with two",
                cases: [Task::PUSH, Task::PICK, Task::DRAWER, Task::INSERT, Task::OBSTACLE_PUSH]
                    .into_iter()
                    .flat_map(|task| [(task, 80), (task, 40)])
                    .chain([(Task::DPUSH, 40)])
                    .map(|(task, updates)| {
                        let label = format!("{} updates={updates}", task.name());
                        Case { method: Method::Her, ..Case::new(label, task, 250_000) }
                            .set("replay.updates_per_episode", updates)
                    })
                    .collect(),
            },
            ExperimentName::Forgetting => Self {
                claim: "reaching the object is learned at once and never lost",
                cases: vec![Case {
                    until: 0.0,
                    ..Case::new("push to the end".to_owned(), Task::PUSH, 200_000)
                }],
            },
            ExperimentName::Table2 => Self {
                claim: "Table II: 95 % on push after 78,000 steps (HER 580,000 and ACDER 110,000, \
                        both as in ACDER's paper; IHER 80,000, as in its own), on pick after \
                        250,000 (1,680,000, 260,000, 300,000)",
                cases: [Task::PUSH, Task::PICK]
                    .map(|task| Case::new(task.name().to_owned(), task, 300_000))
                    .into(),
            },
        })
    }
}
